// Short messages over the page: answers (status) and refusals (alert). A message takes the place of an earlier one of its
// kind and topic.

const SHOWN_MS = 8000; // answers go by themselves; refusals stay until they are closed
const element = (id) => document.getElementById(id);

/** Shows a text. isAlert: a refusal, which stays; isLasting: an answer that stays; topic: of which only the newest message
 *  stays; takesFocus: moves the focus to the message, from which it returns when the message is closed. */
export function toast(text, { isAlert = false, isLasting = isAlert, topic = text, takesFocus = false } = {}) {
  dismiss(topic);
  const box = make("div", { className: isAlert ? "toast bad" : "toast", tabIndex: -1 });
  box.dataset.topic = topic;
  const before = document.activeElement;
  const close = make("button", { textContent: "×", ariaLabel: "Close the message", title: "Close" });
  close.onclick = () => remove(box, before);
  box.onkeydown = ({ key }) => key === "Escape" && remove(box, before);
  box.append(make("p", { textContent: text }), close);
  element(isAlert ? "alerts" : "answers").append(box);
  if (takesFocus) box.focus({ preventScroll: true });
  if (!isLasting) setTimeout(() => expire(box), SHOWN_MS);
}

/** Removes a message, but not while the focus is in it. */
function expire(box) {
  if (!box.contains(document.activeElement)) return box.remove();
  box.addEventListener("focusout", () => box.remove(), { once: true });
}

/** Removes the messages of a topic. */
export function dismiss(topic) {
  for (const box of document.querySelectorAll(".toast")) if (box.dataset.topic === topic) box.remove();
}

/** Removes all messages. */
export function dismissAll() {
  for (const box of document.querySelectorAll(".toast")) box.remove();
}

function remove(box, before) {
  const hadFocus = box.contains(document.activeElement);
  box.remove();
  if (hadFocus) before?.focus();
}

const make = (tag, properties) => Object.assign(document.createElement(tag), properties);
