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

function loadScript(source) {
  return new Promise((done, fail) => {
    const script = make("script", { src: source });
    script.addEventListener("load", done);
    script.addEventListener("error", () => fail(new Error(`${source} is missing`)));
    document.head.append(script);
  });
}

async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

function hasWebGL() {
  const canvas = document.createElement("canvas");
  return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
}

// The loaded scene, with one animation for each plan that was carried out.
class Stage {
  static async load() {
    if (!hasWebGL()) throw new Error("this browser has no WebGL, or it is switched off");
    await Promise.all([loadScript("page/three.js"), loadScript("page/scene_data.js")]);
    const buffer = await unpack(window.sceneData);
    window.sceneData = null;
    const gltf = await new Promise((done, fail) => new THREE.GLTFLoader().parse(buffer, "", done, fail));
    return new Stage(gltf);
  }

  constructor(gltf) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.physicallyCorrectLights = true;
    this.renderer.outputEncoding = THREE.sRGBEncoding;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKDROP);
    this.scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, GROUND, AMBIENT));
    gltf.scene.updateMatrixWorld(true);
    this.mixer = new THREE.AnimationMixer(gltf.scene);
    this.clips = new Map(gltf.animations.map((clip) => [clip.name, clip]));
    this.setCamera(gltf.scene.getObjectByName("camera"));
    this.setSurfaces(gltf.scene);
  }

  // Start with the view of the videos, and rotate about its centre.
  setCamera(given) {
    this.camera = new THREE.PerspectiveCamera(given.fov, given.aspect, given.near, given.far);
    const eye = given.getWorldPosition(new THREE.Vector3());
    const ahead = given.getWorldDirection(new THREE.Vector3());
    this.middle = eye.clone().addScaledVector(ahead, given.userData.distance);
    this.home = new THREE.Spherical().setFromVector3(eye.sub(this.middle));
    this.reset();
  }

  // Enable shadows, and keep printed text sharp at grazing angles.
  setSurfaces(scene) {
    scene.traverse((node) => {
      if (node.isMesh) node.castShadow = node.receiveShadow = true;
      if (node.isMesh && node.material.map) node.material.map.anisotropy = this.renderer.capabilities.getMaxAnisotropy();
      if (!node.isDirectionalLight) return;
      // A directional light of the file shines along its -z.
      node.castShadow = node.name.includes("key");
      node.shadow.mapSize.set(SHADOW_PIXELS, SHADOW_PIXELS);
      Object.assign(node.shadow.camera, { left: -SHADOW_HALF, right: SHADOW_HALF, bottom: -SHADOW_HALF, top: SHADOW_HALF, far: 8 });
      node.shadow.normalBias = 0.004;
    });
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

  // Set the poses at a simulated time of a plan's run.
  pose(name, time) {
    this.mixer.stopAllAction();
    const action = this.mixer.clipAction(this.clips.get(name));
    action.setLoop(THREE.LoopOnce, 1);
    action.clampWhenFinished = true;
    action.reset().play();
    this.mixer.setTime(time);
  }

  draw(canvas, name, time) {
    const density = Math.min(MAX_DENSITY, devicePixelRatio);
    const width = Math.round(canvas.clientWidth * density), height = Math.round(canvas.clientHeight * density);
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const drawn = this.renderer.domElement;
    if (drawn.width !== width || drawn.height !== height) this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.camera.position.setFromSpherical(this.orbit).add(this.middle);
    this.camera.lookAt(this.middle);
    this.pose(name, time);
    this.renderer.render(this.scene, this.camera);
    canvas.getContext("2d").drawImage(drawn, 0, 0);
  }
}

// The scene in a panel. It is drawn only while it is shown.
class SceneView {
  constructor(plan, pictures) {
    this.plan = plan;
    this.pictures = pictures;
    this.time = 0;
    this.canvas = make("canvas", {
      class: "scene", tabindex: 0, role: "application",
      "aria-label": `3-D scene of plan ${plan.index}. Arrow keys turn it, plus and minus zoom, Home resets the view.`,
    });
    this.note = make("p", { class: "scene-note", role: "status" }, "The 3-D scene is loading.");
    this.element = make("div", { class: "scene-box" }, this.canvas, this.note);
    this.fingers = new Map();
    this.canvas.addEventListener("pointerdown", (event) => this.touch(event));
    this.canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(end, (event) => this.fingers.delete(event.pointerId));
    }
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  show(time) {
    this.time = time;
    this.draw();
  }

  draw() {
    const { stage, failure } = this.pictures;
    if (failure) this.note.textContent = `No 3-D scene: ${failure}.`;
    if (this.element.hidden || !stage) return;
    this.note.hidden = true;
    stage.draw(this.canvas, `plan ${this.plan.index}`, this.plan.run.begin + this.time);
    this.canvas.dataset.time = String(this.time);
  }

  change(how) {
    if (!this.pictures.stage) return;
    how(this.pictures.stage);
    this.pictures.redraw();
  }

  touch(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  drag(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const span = this.span();
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (span) this.change((stage) => stage.zoom(span / Math.max(1, this.span())));
    else this.change((stage) => stage.turn(TURN * (event.clientX - before[0]), TURN * (event.clientY - before[1])));
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
    this.change((stage) => stage.zoom(ZOOM ** event.deltaY));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const turns = { ArrowLeft: [-KEY_TURN, 0], ArrowRight: [KEY_TURN, 0], ArrowUp: [0, -KEY_TURN], ArrowDown: [0, KEY_TURN] };
    const zooms = { "+": 1 / KEY_ZOOM, "=": 1 / KEY_ZOOM, "-": KEY_ZOOM };
    if (turns[event.key]) this.change((stage) => stage.turn(...turns[event.key]));
    else if (zooms[event.key]) this.change((stage) => stage.zoom(zooms[event.key]));
    else if (event.key === "Home") this.change((stage) => stage.reset());
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

// Which picture of a run is shown, video or 3-D; the scene is loaded when it is first needed.
class Pictures {
  // `choose`: called after a change of the choice; `update`: draws everything again.
  constructor(element, data, { choose, update, inScene }) {
    this.available = data.scene;
    this.update = update;
    this.inScene = inScene && data.scene;
    const both = data.scene && data.plans.some((plan) => plan.run && plan.run.video);
    if (!data.scene) return;
    const hint = make("span", { class: "small" }, "Drag to turn; after a click the wheel zooms, and so do two fingers. Keys: arrows, + and −, Home.");
    const buttons = [["Video", false], ["3-D", true]].map(([name, scene]) => {
      const button = make("button", { type: "button" }, name);
      button.addEventListener("click", () => {
        this.inScene = scene;
        tell();
        choose();
      });
      return button;
    });
    const tell = () => {
      buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(this.inScene === Boolean(i))));
      hint.hidden = both && !this.inScene;
    };
    tell();
    element.hidden = false;
    element.append(...(both ? buttons : []), hint);
  }

  // Return the scene of a plan, or null where it was not carried out.
  view(plan) {
    return this.available && plan.run ? new SceneView(plan, this) : null;
  }

  // Show the chosen picture of a panel; without a video, its scene.
  arrange(panel) {
    if (!panel.scene) return;
    const inScene = this.inScene || !panel.video;
    if (panel.video) panel.video.hidden = inScene;
    panel.scene.element.hidden = !inScene;
    if (inScene && !this.loading) {
      this.loading = this.load();
    }
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

  redraw() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.update();
    });
  }
}
