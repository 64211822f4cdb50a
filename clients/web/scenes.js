// Which scene runs: the list of the service, uploads by drag and drop or by file chooser, and the plan of what is modelled.

import { ask, send } from "./api.js";

const KINDS = /\.(toml|json)$/i;
const element = (id) => document.getElementById(id);

export class Scenes {
  /** radar(): the id of the radar that is watched. */
  constructor(radar) {
    this.radar = radar;
    this.offers = [];
    this.running = "";
    element("scene").onchange = () => this.showChoice();
    element("load-scene").onclick = () => this.load(element("scene").value);
    element("remove-scene").onclick = () => this.remove(element("scene").value);
    element("files").onchange = () => this.take([...element("files").files]);
    this.bindDrop();
  }

  bindDrop() {
    const shows = (isOver) => document.body.classList.toggle("dropping", isOver);
    const isFiles = (event) => event.dataTransfer?.types.includes("Files");
    addEventListener("dragover", (event) => {
      if (!isFiles(event)) return;
      event.preventDefault();
      shows(true);
    });
    addEventListener("dragleave", (event) => event.relatedTarget === null && shows(false));
    addEventListener("drop", (event) => {
      if (!isFiles(event)) return;
      event.preventDefault();
      shows(false);
      this.take([...event.dataTransfer.files]);
    });
  }

  /** A hello: what runs, and what is modelled of it. */
  adopt(hello) {
    showPlan(hello.plan);
    if (this.running !== hello.scene.name || !this.offers.length) this.list(hello.scene.name);
  }

  /** Asks what is on offer; running: the title of the scene that runs; chosen: the name to select. */
  async list(running = this.running, chosen = null) {
    this.running = running;
    this.offers = await ask("scenes").catch(() => []); // the feed goes on without the list
    const isChosen = (offer) => (chosen ? offer.name === chosen : (offer.title ?? offer.name) === running);
    const options = this.offers.map((offer) => new Option(titleOf(offer), offer.name, false, isChosen(offer)));
    if (!this.offers.some(isChosen)) options.unshift(new Option(`${running} (running)`, "", true, true));
    element("scene").replaceChildren(...options);
    this.showChoice();
  }

  showChoice() {
    const offer = this.offers.find(({ name }) => name === element("scene").value);
    element("load-scene").disabled = !offer;
    element("remove-scene").hidden = offer?.origin !== "uploaded";
    element("scene-about").textContent = offer ? [offer.summary, ...(offer.problems ?? [])].filter(Boolean).join("\n") : "";
  }

  /** Runs a scene of the list. */
  load(name) {
    return this.work(`Preparing ${name} …`, async () => {
      const answer = await ask(`radars/${encodeURIComponent(this.radar())}/scene`, "PUT", { scene: name });
      if (answer.plan) showPlan(answer.plan);
      return `${name} is on the air: ${answer.bodies} ${answer.bodies === 1 ? "body" : "bodies"}.`;
    });
  }

  remove(name) {
    return this.work(`Removing ${name} …`, async () => {
      await ask(`scenes/${encodeURIComponent(name)}`, "DELETE");
      await this.list();
      return `${name} is removed.`;
    });
  }

  /** Uploads the one scene among `files`, with the meshes beside it, and runs it. */
  async take(files) {
    const scenes = files.filter((file) => KINDS.test(file.name));
    if (scenes.length !== 1) {
      const found = scenes.map((file) => file.name).join(", ") || "none";
      return this.say(`Give one scene (.toml or .json) together with its meshes; here: ${found}.`, true);
    }
    const [scene] = scenes;
    const name = shelfName(scene.name);
    const isKept = await this.work(`Sending ${scene.name} …`, async () => {
      await send("scenes", form(name, scene, files));
      await this.list(this.running, name);
      return "";
    });
    element("files").value = ""; // so that the same file can be chosen again
    if (isKept) await this.load(name);
  }

  /** Does what may be refused, saying so; whether it went well. */
  async work(meanwhile, act) {
    this.say(meanwhile, false);
    element("load-scene").disabled = true;
    try {
      this.say(await act(), false);
      return true;
    } catch (refused) {
      this.say(refused.message, true);
      return false;
    } finally {
      this.showChoice();
    }
  }

  say(text, isBad) {
    element("scene-answer").textContent = text;
    element("scene-answer").classList.toggle("bad", isBad);
  }
}

const titleOf = (offer) => (offer.origin === "uploaded" ? `${offer.name} (uploaded)` : offer.name);

/** The name under which the service keeps an upload: the file's own without what a name may not hold. */
export function shelfName(file) {
  const plain = file.replace(KINDS, "").replace(/[^A-Za-z0-9 _-]+/g, "-").replace(/^[^A-Za-z0-9]+/, "");
  return plain.slice(0, 64) || "scene";
}

function form(name, scene, files) {
  const made = new FormData();
  made.set("name", name);
  made.set("scene", scene);
  for (const file of files) if (file !== scene) made.append("files", file);
  return made;
}

/** The plan: what is modelled and how, what is not and why. */
function showPlan({ choices = [] }) {
  const modelled = choices.filter((choice) => choice.modelled).length;
  element("plan").querySelector("summary").textContent = `Plan: ${modelled} of ${choices.length} modelled`;
  element("plan").querySelector("ul").replaceChildren(...choices.map(choiceItem));
  element("plan").hidden = choices.length === 0;
}

function choiceItem({ what, modelled, how }) {
  const item = document.createElement("li");
  item.className = modelled ? "modelled" : "left-out";
  const name = document.createElement("strong");
  name.textContent = what;
  const state = document.createElement("span");
  state.className = "hidden-text";
  state.textContent = modelled ? ", modelled: " : ", not modelled: ";
  item.append(name, state, ` ${how}`);
  return item;
}
