// The running scene: the service's list of scenes, uploads by drag and drop or file chooser, and the plan.

import { NoAnswer, callApi, postForm } from "./api.js";
import { toast } from "./toast.js";

const SCENE_FILE = /\.(toml|json)$/i;
const element = (id) => document.getElementById(id);

export const scenesPanel = (page) => new Scenes(page);

class Scenes {
  constructor(page) {
    this.page = page;
    this.shown = null; // id of the radar of the last hello
    this.entries = [];
    this.running = "";
    this.isWorking = false;
    this.ownEpoch = null; // of the feed, begun by the newest scene that this page has started
    element("scene").onchange = () => this.showChoice();
    element("load-scene").onclick = () => this.load(element("scene").value);
    element("remove-scene").onclick = () => this.remove(element("scene").value);
    element("files").onchange = () => this.upload([...element("files").files]);
    this.bindDrop();
  }

  bindDrop() {
    const showDrop = (isOver) => document.body.classList.toggle("dropping", isOver);
    const isFiles = (event) => event.dataTransfer?.types.includes("Files");
    addEventListener("dragover", (event) => {
      if (!isFiles(event)) return;
      event.preventDefault();
      showDrop(true);
    });
    addEventListener("dragleave", (event) => event.relatedTarget === null && showDrop(false));
    addEventListener("drop", (event) => {
      if (!isFiles(event)) return;
      event.preventDefault();
      showDrop(false);
      this.upload([...event.dataTransfer.files]);
    });
  }

  /** Shows the scene and the plan of a hello. */
  hello(hello) {
    if (this.shown === hello.radar.id) this.tellOthers(hello.epoch, hello.scene.name);
    this.shown = hello.radar.id;
    showPlan(hello.plan);
    if (this.running !== hello.scene.name || !this.entries.length) this.list(hello.scene.name);
  }

  /** Says that another viewer has started a scene. epoch, name: of the scene that runs now; it may begin long after the answer. */
  tellOthers(epoch, name) {
    const isOther = this.running && name !== this.running && !this.isWorking && epoch !== this.ownEpoch;
    if (isOther) toast(`Scene ${name} started by another viewer`, { topic: "Scene" });
  }

  /** Fetches the list of scenes. running: title of the running scene; chosen: name of the scene to select, or null. */
  async list(running = this.running, chosen = null) {
    this.running = running;
    this.entries = await callApi("scenes").catch(() => []); // the feed works without the list
    const isChosen = (entry) => (chosen ? entry.name === chosen : (entry.title ?? entry.name) === running);
    const options = this.entries.map((entry) => new Option(titleOf(entry), entry.name, false, isChosen(entry)));
    if (!this.entries.some(isChosen)) options.unshift(new Option(`${running} (running)`, "", true, true));
    element("scene").replaceChildren(...options);
    this.showChoice();
  }

  /** Clears the answer of a service that has ended. */
  forget() {
    this.showAnswer("");
  }

  showChoice() {
    const entry = this.entries.find(({ name }) => name === element("scene").value);
    element("load-scene").disabled = !entry;
    element("remove-scene").hidden = entry?.origin !== "uploaded";
    element("scene-about").textContent = entry ? [entry.summary, ...(entry.problems ?? [])].filter(Boolean).join("\n") : "";
  }

  /** Starts a scene of the list. title: the name of the user's file, if it was uploaded just now. */
  load(name, title = name) {
    return this.work(`Preparing ${title} …`, title, async () => {
      const answer = await callApi(`radars/${encodeURIComponent(this.page.radar.id)}/scene`, "PUT", { scene: name });
      this.ownEpoch = answer.epoch;
      if (answer.plan) showPlan(answer.plan);
      const stored = title === name ? "" : ` as ${name}`;
      return `${title} is on the air${stored}: ${answer.bodies} ${answer.bodies === 1 ? "body" : "bodies"}.`;
    });
  }

  remove(name) {
    return this.work(`Removing ${name} …`, name, async () => {
      await callApi(`scenes/${encodeURIComponent(name)}`, "DELETE");
      await this.list();
      return `${name} is removed.`;
    });
  }

  /** Uploads the one scene among `files`, with the meshes beside it, and runs it. */
  async upload(files) {
    const scenes = files.filter((file) => SCENE_FILE.test(file.name));
    if (scenes.length !== 1) {
      const names = scenes.map((file) => file.name).join(", ") || "none";
      const text = `Choose one scene (.toml or .json) and its meshes. Scenes among these files: ${names}.`;
      return this.showAnswer(text, { isAlert: true, takesFocus: true });
    }
    const [scene] = scenes;
    const name = sceneName(scene.name);
    const isStored = await this.work(`Sending ${scene.name} …`, scene.name, async () => {
      await postForm("scenes", form(name, scene, files));
      await this.list(this.running, name);
      return "";
    });
    element("files").value = ""; // so that the same file can be chosen again
    if (isStored) await this.load(name, scene.name);
  }

  /** Runs an action that the service may refuse, and shows its answer; returns whether it succeeded. title: of the scene or
   *  file; the service has stored the file under a name of its own. */
  async work(progress, title, action) {
    this.showAnswer(progress, { isLasting: true });
    element("load-scene").disabled = this.isWorking = true;
    try {
      this.showAnswer(await action(), { takesFocus: true });
      return true;
    } catch (refused) {
      const text = refused.message.replaceAll(/\bscene\.(toml|json)\b/g, title);
      const verdict = refused instanceof NoAnswer ? "did not arrive" : "is refused";
      this.showAnswer(`${title} ${verdict}:\n${text}`, { isAlert: true, takesFocus: true });
      return false;
    } finally {
      this.isWorking = false;
      this.showChoice();
    }
  }

  /** Shows an answer in the panel and over the page. */
  showAnswer(text, options = {}) {
    element("scene-answer").textContent = text;
    element("scene-answer").classList.toggle("bad", Boolean(options.isAlert));
    if (text) toast(text, { topic: "Scene", ...options });
  }
}

const titleOf = (entry) => (entry.origin === "uploaded" ? `${entry.name} (uploaded)` : entry.name);

/** The name of an uploaded scene: the file's name without characters that the service does not allow. */
export function sceneName(file) {
  const plain = file.replace(SCENE_FILE, "").replace(/[^A-Za-z0-9 _-]+/g, "-").replace(/^[^A-Za-z0-9]+/, "");
  return plain.slice(0, 64) || "scene";
}

function form(name, scene, files) {
  const data = new FormData();
  data.set("name", name);
  data.set("scene", scene);
  for (const file of files) if (file !== scene) data.append("files", file);
  return data;
}

/** Shows the plan: each effect, whether it is modelled, and how or why not. */
function showPlan({ choices = [] }) {
  const modelled = choices.filter((choice) => choice.modelled).length;
  element("plan").querySelector("summary").textContent = `Plan: ${modelled} of ${choices.length} modelled`;
  element("plan").querySelector("ul").replaceChildren(...choices.map(planItem));
  element("plan").hidden = choices.length === 0;
}

function planItem({ what, modelled, how }) {
  const item = document.createElement("li");
  item.className = modelled ? "modelled" : "not-modelled";
  const name = document.createElement("strong");
  name.textContent = what;
  const state = document.createElement("span");
  state.className = "hidden-text";
  state.textContent = modelled ? ", modelled: " : ", not modelled: ";
  item.append(name, state, ` ${how}`);
  return item;
}
