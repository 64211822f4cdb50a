// The elements of the controls that a radar declares. A control is in the section of index.html that names where it acts.

const WITH_OWN_ELEMENTS = ["range_m", "pace"]; // with scales, buttons and keys: index.html has their elements
const UNITS = { "rev/min": "rpm", "%": "" }; // as the page shows them; other units are shown as declared

/** Builds the elements of the declared controls in place of earlier ones. send(change): sends a change to the radar.
 *  Returns for each control, by its name, the function that shows its value: show(value, isBusy, isRefused), where isBusy
 *  means that a change is being sent, and isRefused that one has failed. */
export function buildWidgets(definitions, send) {
  for (const group of document.querySelectorAll("[data-acts-on] :is(.switches, .sliders, .fields)")) group.replaceChildren();
  const built = definitions.filter(({ name }) => !WITH_OWN_ELEMENTS.includes(name));
  return Object.fromEntries(built.map((definition) => [definition.name, buildWidget(definition, send)]));
}

function buildWidget(definition, send) {
  const [group, make] = widgetOf(definition);
  const { elements, show } = make(definition, (value) => send({ [definition.name]: value }));
  document.querySelector(`[data-acts-on~="${definition.acts_on}"] .${group}`).append(...elements);
  return show;
}

/** The group of a control within its section, and the function that makes its elements. */
function widgetOf({ kind, step }) {
  if (kind === "switch") return ["switches", makeSwitch];
  return step === null ? ["fields", makeField] : ["sliders", makeSlider];
}

/** A button, pressed while the control is on. */
function makeSwitch({ name, label, description }, send) {
  const button = create("button", { id: name, title: description, textContent: label });
  button.onclick = () => send(button.ariaPressed !== "true");
  const show = (value) => (button.ariaPressed = String(Boolean(value)));
  return { elements: [button], show };
}

/** A slider, which sends every value that it passes. */
function makeSlider(definition, send) {
  const { name, minimum, maximum, step, description } = definition;
  const input = create("input", { id: name, type: "range", min: minimum, max: maximum, step, title: description });
  const output = create("output", { id: `${name}-value`, htmlFor: name, value: "–" });
  input.oninput = () => {
    output.value = input.value;
    send(Number(input.value));
  };
  const show = (value, isBusy) => {
    if (input !== document.activeElement || !isBusy) input.value = value;
    output.value = input.value;
  };
  return { elements: [create("label", { htmlFor: name, textContent: labelText(definition) }), input, output], show };
}

/** A field for a typed number, which sends it when the user leaves the field or presses Enter. */
function makeField(definition, send) {
  const { name, minimum, maximum, description } = definition;
  const limits = { min: minimum ?? "", max: maximum ?? "", step: "any" };
  const input = create("input", { id: name, type: "number", inputMode: "decimal", title: description, ...limits });
  input.onchange = () => input.reportValidity() && send(Number(input.value));
  const show = (value, isBusy, isRefused) => {
    if (input !== document.activeElement || isRefused) input.value = value;
  };
  const label = create("label", { className: "row" });
  label.append(labelText(definition), input);
  return { elements: [label], show };
}

function labelText({ label, unit }) {
  const shown = UNITS[unit] ?? unit;
  return shown ? `${label}, ${shown}` : label;
}

const create = (tag, properties) => Object.assign(document.createElement(tag), properties);
