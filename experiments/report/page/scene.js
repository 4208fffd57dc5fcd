"use strict";
// The runs in 3-D: one scene for all plans, drawn for each panel in turn, and the choice between it and videos.

const TURN = 0.008, KEY_TURN = 0.12; // rad for a pixel, and for a key
const ZOOM = 1.0015, KEY_ZOOM = 1.15; // for a unit of the wheel, and for a key
const NEAREST = 0.25, FURTHEST = 6; // m from the centre of rotation
const HIGHEST = 0.05, LOWEST = 1.65; // rad from straight above
const SHADOW_HALF = 1.1; // m; half the width of what casts shadows
const SHADOW_PIXELS = 2048;
const BACKDROP = 0x959da6, GROUND = 0x8a8078;
const AMBIENT = 2.1; // illuminance from all around; the lights are in the file
const MAX_DENSITY = 2; // greatest number of rendered pixels per CSS pixel

const KEYS = {
  ArrowLeft: (stage) => stage.turn(-KEY_TURN, 0), ArrowRight: (stage) => stage.turn(KEY_TURN, 0),
  ArrowUp: (stage) => stage.turn(0, -KEY_TURN), ArrowDown: (stage) => stage.turn(0, KEY_TURN),
  "+": (stage) => stage.zoom(1 / KEY_ZOOM), "=": (stage) => stage.zoom(1 / KEY_ZOOM), "-": (stage) => stage.zoom(KEY_ZOOM),
  Home: (stage) => stage.reset(),
};

function loadScript(source) {
  return new Promise((done, fail) => {
    const script = make("script", { src: source });
    script.onload = done;
    script.onerror = () => fail(new Error(`${source} is missing`));
    document.head.append(script);
  });
}

// The loaded scene, with one animation for each plan that was carried out.
class Stage {
  static async load() {
    if (!document.createElement("canvas").getContext("webgl2")) throw new Error("this browser has no WebGL, or it is switched off");
    await Promise.all([loadScript("page/three.js"), loadScript("page/scene_data.js")]);
    const packed = await fetch(`data:;base64,${window.sceneData}`);
    const file = await new Response(packed.body.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    return new Stage(await new THREE.GLTFLoader().parseAsync(file, ""));
  }

  constructor(gltf) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.physicallyCorrectLights = true;
    this.renderer.outputEncoding = THREE.sRGBEncoding;
    Object.assign(this.renderer.shadowMap, { enabled: true, type: THREE.PCFSoftShadowMap });
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKDROP);
    this.scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, GROUND, AMBIENT));
    gltf.scene.traverse((node) => this.finish(node));
    this.mixer = new THREE.AnimationMixer(gltf.scene);
    this.clips = new Map(gltf.animations.map((clip) => [clip.name, clip]));
    // Start with the view of the videos, and rotate about its centre.
    this.camera = gltf.scene.getObjectByName("camera");
    this.scene.attach(this.camera);
    const ahead = this.camera.getWorldDirection(new THREE.Vector3());
    this.middle = this.camera.position.clone().addScaledVector(ahead, this.camera.userData.distance);
    this.home = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(this.middle));
    this.reset();
  }

  // Enable shadows, and keep printed text sharp at grazing angles.
  finish(node) {
    if (node.isMesh) node.castShadow = node.receiveShadow = true;
    if (node.isMesh && node.material.map) node.material.map.anisotropy = this.renderer.capabilities.getMaxAnisotropy();
    if (!node.isDirectionalLight) return;
    node.castShadow = node.name.includes("key");
    node.shadow.mapSize.set(SHADOW_PIXELS, SHADOW_PIXELS);
    Object.assign(node.shadow.camera, { left: -SHADOW_HALF, right: SHADOW_HALF, bottom: -SHADOW_HALF, top: SHADOW_HALF, far: 8 });
    node.shadow.normalBias = 0.004;
  }

  reset() {
    this.orbit = this.home.clone();
  }

  turn(right, down) {
    this.orbit.theta -= right;
    this.orbit.phi = Math.min(LOWEST, Math.max(HIGHEST, this.orbit.phi - down));
  }

  zoom(factor) {
    this.orbit.radius = Math.min(FURTHEST, Math.max(NEAREST, this.orbit.radius * factor));
  }

  // Draw a plan's run at a simulated time.
  draw(canvas, name, time) {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((size) => Math.round(size * Math.min(MAX_DENSITY, devicePixelRatio)));
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.camera.position.setFromSpherical(this.orbit).add(this.middle);
    this.camera.lookAt(this.middle);
    this.mixer.stopAllAction();
    const action = this.mixer.clipAction(this.clips.get(name)).setLoop(THREE.LoopOnce, 1);
    action.clampWhenFinished = true;
    action.reset().play();
    this.mixer.setTime(time);
    this.renderer.render(this.scene, this.camera);
    canvas.getContext("2d").drawImage(this.renderer.domElement, 0, 0);
  }
}

// The scene in a panel. It is drawn only while it is shown.
class SceneView {
  constructor(plan, pictures) {
    Object.assign(this, { plan, pictures, time: 0, fingers: new Map() });
    this.canvas = make("canvas", {
      class: "scene", tabindex: 0, role: "application",
      "aria-label": `3-D scene of plan ${plan.index}. Arrow keys turn it, plus and minus zoom, Home resets the view.`,
    });
    this.note = make("p", { class: "scene-note", role: "status" }, "The 3-D scene is loading.");
    this.element = make("div", { class: "scene-box" }, this.canvas, this.note);
    this.canvas.onpointerdown = (event) => this.touch(event);
    this.canvas.onpointermove = (event) => this.drag(event);
    this.canvas.onpointerup = this.canvas.onpointercancel = (event) => this.fingers.delete(event.pointerId);
    this.canvas.onkeydown = (event) => this.key(event);
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    new ResizeObserver(() => this.show(this.time)).observe(this.canvas);
  }

  show(time) {
    const { stage, failure } = this.pictures;
    this.time = time;
    if (failure) this.note.textContent = `No 3-D scene: ${failure}.`;
    if (this.element.hidden || !stage) return;
    this.note.hidden = true;
    stage.draw(this.canvas, `plan ${this.plan.index}`, this.plan.run.begin + time);
    this.canvas.dataset.time = String(time);
  }

  touch(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  // One finger turns the scene, two zoom it.
  drag(event) {
    const before = this.fingers.get(event.pointerId), span = this.span();
    if (!before) return;
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (span) this.pictures.change((stage) => stage.zoom(span / Math.max(1, this.span())));
    else this.pictures.change((stage) => stage.turn(TURN * (event.clientX - before[0]), TURN * (event.clientY - before[1])));
  }

  // How far two fingers are apart; 0 for one finger.
  span() {
    const [one, two] = this.fingers.values();
    return two ? Math.hypot(one[0] - two[0], one[1] - two[1]) : 0;
  }

  // The wheel scrolls the page until the scene is clicked.
  wheel(event) {
    if (document.activeElement !== this.canvas && !event.ctrlKey) return;
    event.preventDefault();
    this.pictures.change((stage) => stage.zoom(ZOOM ** event.deltaY));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    this.pictures.change(KEYS[event.key]);
  }
}

// Which picture of a run is shown, video or 3-D; the scene is loaded when it is first needed.
class Pictures {
  // `choose`: called after a change of the choice; `update`: draws everything again.
  constructor(element, data, { choose, update, inScene }) {
    Object.assign(this, { available: data.scene, inScene: inScene && data.scene, update });
    const both = data.scene && data.plans.some((plan) => plan.run && plan.run.video);
    const hint = make("span", { class: "small" }, "Drag to turn; after a click the wheel zooms, and so do two fingers. Keys: arrows, + and −, Home.");
    const buttons = ["Video", "3-D"].map((name) => make("button", { type: "button" }, name));
    const tell = () => {
      buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(this.inScene === Boolean(i))));
      hint.hidden = both && !this.inScene;
    };
    buttons.forEach((button, i) => {
      button.onclick = () => {
        this.inScene = Boolean(i);
        tell();
        choose();
      };
    });
    tell();
    element.hidden = !data.scene;
    element.append(...(both ? buttons : []), hint);
  }

  // Return the scene of a plan, or null where it was not carried out.
  view(plan) {
    return this.available && plan.run ? new SceneView(plan, this) : null;
  }

  // Show the chosen picture of a panel; without a video, its scene.
  arrange({ scene, video }) {
    if (!scene) return;
    scene.element.hidden = Boolean(video) && !this.inScene;
    if (video) video.hidden = this.inScene;
    if (!scene.element.hidden) this.loading ??= this.load();
  }

  // Load the scene; return whether it is shown.
  async load() {
    try {
      this.stage = await Stage.load();
    } catch (error) {
      this.failure = error.message;
    }
    this.update();
    return Boolean(this.stage);
  }

  // Change the view of all panels, which are drawn again once per frame of the browser.
  change(how) {
    if (!this.stage) return;
    how(this.stage);
    cancelAnimationFrame(this.waits);
    this.waits = requestAnimationFrame(this.update);
  }
}
