"use strict";
// The runs in 3-D: one scene for all plans, drawn for each panel in turn.

const NEAREST = 0.25, FURTHEST = 6; // m from the centre of rotation
const HIGHEST = 0.05, LOWEST = 1.65; // rad from straight above
const KEY_TURN = 0.12, KEY_ZOOM = 1.15; // rad and factor for a key
const SHADOW = { left: -1.1, right: 1.1, bottom: -1.1, top: 1.1, far: 8 }; // m; holds all that casts shadows
const SHADOW_PIXELS = 2048;
const BACKDROP = 0x959da6, GROUND = 0x8a8078;
const AMBIENT = 2.1; // illuminance from all around; the lights are in the file
const MAX_DENSITY = 2; // greatest number of rendered pixels per CSS pixel

// Steps to the left, down and away for a key.
const KEYS = {
  ArrowLeft: [1, 0, 0], ArrowRight: [-1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
  "+": [0, 0, -1], "=": [0, 0, -1], "-": [0, 0, 1],
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
    Object.assign(this.renderer, { physicallyCorrectLights: true, outputEncoding: THREE.sRGBEncoding });
    Object.assign(this.renderer.shadowMap, { enabled: true, type: THREE.PCFSoftShadowMap });
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKDROP);
    this.scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, GROUND, AMBIENT));
    gltf.scene.traverse((node) => this.finish(node));
    this.mixer = new THREE.AnimationMixer(gltf.scene);
    this.clips = gltf.animations;
    // Start with the view of the videos, and rotate about its centre.
    this.camera = gltf.scene.getObjectByName("camera");
    this.scene.attach(this.camera);
    const ahead = this.camera.getWorldDirection(new THREE.Vector3());
    this.home = this.camera.position.clone();
    this.middle = this.home.clone().addScaledVector(ahead, this.camera.userData.distance);
  }

  // Enable shadows, and keep printed text sharp at grazing angles.
  finish(node) {
    if (node.isMesh) node.castShadow = node.receiveShadow = true;
    if (node.isMesh && node.material.map) node.material.map.anisotropy = this.renderer.capabilities.getMaxAnisotropy();
    if (!node.isDirectionalLight) return;
    node.castShadow = node.name.includes("key");
    node.shadow.mapSize.set(SHADOW_PIXELS, SHADOW_PIXELS);
    Object.assign(node.shadow.camera, SHADOW);
    node.shadow.normalBias = 0.004;
  }

  // Let the pointer on a canvas turn and zoom the scene for all; the wheel scrolls the page until the canvas has the focus.
  control(canvas, update) {
    const controls = new THREE.OrbitControls(this.camera, canvas);
    Object.assign(controls, { target: this.middle, minDistance: NEAREST, maxDistance: FURTHEST, minPolarAngle: HIGHEST, maxPolarAngle: LOWEST });
    Object.assign(controls, { enablePan: false, enableZoom: false, rotateSpeed: 0.5 });
    canvas.onfocus = canvas.onblur = (event) => { controls.enableZoom = event.type === "focus"; };
    canvas.onpointerdown = () => canvas.focus({ preventScroll: true });
    canvas.onkeydown = (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !(KEYS[event.key] || event.key === "Home")) return;
      event.preventDefault();
      event.stopPropagation();
      if (event.key === "Home") this.camera.position.copy(this.home);
      else this.step(KEYS[event.key]);
      controls.update();
    };
    controls.update();
    controls.addEventListener("change", update);
  }

  step([left, down, away]) {
    const at = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(this.middle));
    at.set(at.radius * KEY_ZOOM ** away, at.phi + KEY_TURN * down, at.theta + KEY_TURN * left);
    this.camera.position.setFromSpherical(at).add(this.middle);
  }

  // Draw a plan's run at a simulated time.
  draw(canvas, name, time) {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((size) => Math.round(size * Math.min(MAX_DENSITY, devicePixelRatio)));
    if (!width || !height) return;
    Object.assign(canvas, { width, height });
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.mixer.stopAllAction();
    const action = this.mixer.clipAction(this.clips.find((clip) => clip.name === name)).setLoop(THREE.LoopOnce, 1);
    action.clampWhenFinished = true;
    action.reset().play();
    this.mixer.setTime(time);
    this.renderer.render(this.scene, this.camera);
    canvas.getContext("2d").drawImage(this.renderer.domElement, 0, 0);
  }
}

// The scene in a panel. It is drawn only while it is shown, and loaded, for all panels, when one is first shown.
class SceneView {
  // `update` draws all panels again.
  constructor(plan, update) {
    Object.assign(this, { plan, update, time: 0, stage: null });
    this.canvas = make("canvas", {
      class: "scene", tabindex: 0, role: "application",
      "aria-label": `3-D scene of plan ${plan.index}. Arrow keys turn it, plus and minus zoom, Home resets the view.`,
    });
    this.note = make("p", { class: "scene-note", role: "status" }, "The 3-D scene is loading.");
    this.element = make("div", { class: "scene-box" }, this.canvas, this.note);
    new ResizeObserver(() => this.show(null, this.time)).observe(this.canvas);
  }

  // Show or hide it; return whether there is something to see.
  async reveal(shown) {
    this.element.hidden = !shown;
    if (!shown || this.stage) return shown;
    try {
      this.stage = await (SceneView.loading ??= Stage.load());
    } catch (error) {
      this.note.textContent = `No 3-D scene: ${error.message}.`;
      return false;
    }
    this.stage.control(this.canvas, this.update);
    this.note.hidden = true;
    this.update();
    return true;
  }

  show(at, time) {
    this.time = time;
    if (this.element.hidden || !this.stage) return;
    this.stage.draw(this.canvas, `plan ${this.plan.index}`, this.plan.run.begin + time);
    this.canvas.dataset.time = String(time);
  }
}
