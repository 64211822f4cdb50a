// The keys of one character. They can be switched off: who speaks to the computer may set them off unknowingly.

const element = (id) => document.getElementById(id);

/** Lets keys act on the controls of the radar and on the preferences of the page, while the setting `keys` is on. */
export function bindKeys(controls, preferences) {
  const actions = {
    "+": () => controls.stepRange(1),
    "=": () => controls.stepRange(1), // the same key without Shift on many keyboards
    "-": () => controls.stepRange(-1),
    z: () => preferences.zoom(2),
    x: () => preferences.zoom(1 / 2),
    o: () => preferences.lookAhead(),
    c: () => element("centre").click(),
    h: () => preferences.next("orientation"),
    n: () => preferences.next("palette"),
    t: () => preferences.next("trails"),
    p: () => controls.togglePause(),
    s: () => controls.paused && element("step").click(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || preferences.settings.keys === "off") return;
    if (event.target.closest("select, input[type=number], input[type=password]")) return;
    actions[event.key.toLowerCase()]?.();
  });
}
