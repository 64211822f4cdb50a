// The REST side of the service. Addresses are relative to the page, so that it also works behind a path of a proxy.

/** Answers the JSON of an address under api/. Throws an Error with the service's own words where it refuses. */
export async function ask(path, method = "GET", body = undefined) {
  const options = body === undefined ? { method } : { method, body: JSON.stringify(body), headers: { "Content-Type": "application/json" } };
  const answer = await fetch(new URL(`api/${path}`, document.baseURI), options);
  const text = await answer.text();
  if (!answer.ok) throw new Error(refusal(text) || `${method} ${path}: the service answered ${answer.status}`);
  return text ? JSON.parse(text) : null;
}

function refusal(text) {
  try {
    const { detail } = JSON.parse(text);
    if (Array.isArray(detail)) return detail.map((d) => d.msg ?? String(d)).join("\n");
    return detail ?? "";
  } catch {
    return ""; // not JSON: a proxy's page, say
  }
}

/** The websocket address of a radar's feed. since: "EPOCH:SEQ" to go on from, or empty. */
export function feedAddress(radar, bins, since) {
  const address = new URL(`api/radars/${encodeURIComponent(radar)}/feed`, document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.searchParams.set("encoding", "u8");
  address.searchParams.set("bins", bins);
  if (since) address.searchParams.set("since", since);
  return address.href;
}
