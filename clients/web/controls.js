// The controls that act on the radar itself, for everybody who watches it. Each goes out as a PATCH, at most one at a time.

import { ask } from "./api.js";
import { rangeScales, rangeText } from "./units.js";

const SLIDERS = ["gain", "sea", "rain"];
const element = (id) => document.getElementById(id);

export class Controls {
  /** say(text): shows what the service refused. unit(): "nm" or "m". */
  constructor(say, unit) {
    this.say = say;
    this.unit = unit;
    this.state = {};
    this.health = null;
    this.waiting = null;
    this.busy = false;
    this.bind();
  }

  bind() {
    for (const name of SLIDERS) {
      element(name).oninput = () => {
        element(`${name}-value`).value = element(name).value;
        this.send({ [name]: Number(element(name).value) });
      };
    }
    element("range").onchange = () => this.send({ range_m: Number(element("range").value) });
    element("range-up").onclick = () => this.stepRange(1);
    element("range-down").onclick = () => this.stepRange(-1);
    element("transmit").onclick = () => this.send({ transmit: !this.state.transmit });
    element("pause").onclick = () => this.togglePause();
    element("step").onclick = () => this.send({ pace: { state: "step", steps: this.azimuths } });
    element("factor").onchange = () => {
      const { value } = element("factor");
      this.send({ pace: { factor: value === "max" ? value : Number(value) } });
    };
    element("rpm").onchange = () => element("rpm").reportValidity() && this.send({ rpm: Number(element("rpm").value) });
  }

  /** Takes over a radar's hello: its name and limits, and its controls as they stand. */
  adopt(hello) {
    this.radar = hello.radar.id;
    this.azimuths = hello.radar.azimuths;
    this.longest = hello.radar.range_max_m;
    this.show(hello.controls);
  }

  /** Asks for the controls as they stand, which others may have turned, and how the radar does. */
  async refresh() {
    if (this.radar === undefined || this.busy || this.waiting) return;
    const health = ask("health").catch(() => null); // the feed tells of a lost line
    const controls = await ask(`radars/${encodeURIComponent(this.radar)}/controls`).catch(() => null);
    this.health = (await health)?.radars.find((one) => one.id === this.radar) ?? null;
    if (controls && !this.busy) this.show(controls);
  }

  /** The factor that the service reaches where that is less than what it is asked for; null where it keeps its pace. */
  get behind() {
    return this.health?.state === "behind" ? this.health.factor_reached : null;
  }

  togglePause() {
    this.send({ pace: { state: this.paused ? "run" : "pause" } });
  }

  stepRange(by) {
    const scales = rangeScales(this.longest, this.unit());
    const now = this.state.range_m ?? this.longest;
    const slack = now * 1e-3; // a scale and the range that it led to differ by less than a cell
    const next = by > 0 ? scales.find((scale) => scale > now + slack) : scales.findLast((scale) => scale < now - slack);
    if (next) this.send({ range_m: next });
  }

  get paused() {
    return this.state.pace?.state !== undefined && this.state.pace.state !== "run";
  }

  /** The factor of the pace, or null where spokes come as fast as they can. */
  get factor() {
    const factor = this.state.pace?.factor ?? 1;
    return typeof factor === "number" ? factor : null;
  }

  /** Sends a change; while one is under way later ones gather, the last word for each control winning. */
  async send(change) {
    this.waiting = { ...this.waiting, ...change };
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.waiting) await this.patch();
    } finally {
      this.busy = false;
    }
    await this.refresh();
  }

  async patch() {
    const change = this.waiting;
    this.waiting = null;
    try {
      await ask(`radars/${encodeURIComponent(this.radar)}/controls`, "PATCH", change);
      this.say("");
    } catch (refused) {
      this.say(refused.message);
    }
  }

  show(controls) {
    this.state = { ...this.state, ...controls };
    for (const name of SLIDERS) {
      if (element(name) !== document.activeElement || !this.busy) element(name).value = this.state[name];
      element(`${name}-value`).value = element(name).value;
    }
    if (element("rpm") !== document.activeElement) element("rpm").value = this.state.rpm;
    element("transmit").ariaPressed = String(Boolean(this.state.transmit));
    element("transmit").textContent = this.state.transmit ? "Transmit" : "Standby";
    element("pause").ariaPressed = String(this.paused);
    element("pause").textContent = this.paused ? "Resume" : "Pause";
    element("step").disabled = !this.paused;
    element("factor").value = String(this.state.pace?.factor ?? 1);
    this.showRanges();
  }

  /** Fills the list of range scales in the present unit; a range set elsewhere joins it. */
  showRanges() {
    if (!this.longest) return;
    const now = this.state.range_m ?? this.longest;
    const scales = rangeScales(this.longest, this.unit());
    const nearest = scales.find((scale) => Math.abs(scale - now) < now * 1e-3) ?? now;
    const offered = [...new Set([...scales, nearest])].sort((a, b) => a - b);
    const options = offered.map((scale) => new Option(rangeText(scale, this.unit()), scale, false, scale === nearest));
    if (element("range") !== document.activeElement) element("range").replaceChildren(...options);
    element("range-up").disabled = nearest >= this.longest * 0.999;
    element("range-down").disabled = nearest <= scales[0];
  }
}
