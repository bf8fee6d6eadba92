/** Files and texts that the server makes of a view. */
import { element, openDialog } from "./dom.js";

/**
 * @param {{view: string, request: object, format: string, frame: object}} wanted
 * @param {string} title
 * @param {(message: string, lasts?: boolean) => void} announce
 */
export async function keep(wanted, title, announce) {
  const words = title.toLowerCase().match(/[a-z0-9]+/g) ?? [];
  const name = `${["stickslip", ...words].join("-")}.${wanted.format}`;
  if (wanted.format !== "python") announce(`Making ${name} …`, true); // a film takes a minute
  const reply = await fetch(new URL("export", location.href), {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(wanted),
  }).catch(() => {
    throw new Error("the server does not answer");
  });
  if (!reply.ok) {
    const answer = await reply.json().catch(() => null);
    throw new Error(answer?.error?.message ?? `the server answered ${reply.status}`);
  }
  if (wanted.format === "python")
    return copy(await reply.text(), "Copied: the calls that make this view", announce);
  const url = URL.createObjectURL(await reply.blob());
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
  announce(`Saved ${name}`);
}

/**
 * Onto the clipboard; where that is refused, into a window to copy from.
 * @param {string} text @param {string} done @param {(message: string) => void} announce
 */
export async function copy(text, done, announce) {
  try {
    await navigator.clipboard.writeText(text);
    announce(done);
  } catch {
    const area = element("textarea", { readonly: true, rows: 14, "aria-label": "Text to copy" });
    area.value = text;
    openDialog("Text to copy", "copy", area);
    area.select();
  }
}
