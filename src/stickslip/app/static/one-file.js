/**
 * First of all scripts in a page of one file: what the page and its thread load stands in the page.
 */
{
  /** A `fetch` that knows files by their paths. @param {Record<string, string>} files in base 64 */
  const know = (files) => {
    const bytes = (/** @type {string} */ path) =>
      Uint8Array.from(atob(files[path]), (letter) => letter.charCodeAt(0));
    self.fetch = async (path) => new Response(bytes(String(path)));
  };
  const files = JSON.parse(/** @type {Element} */ (document.querySelector("#files")).innerHTML);
  know(files);

  const beside = Object.entries(files).map(([path, text]) => [path.replace(/^static\//, ""), text]);
  const first = `(${know})(${JSON.stringify(Object.fromEntries(beside))});\n`;
  const Threads = Worker;
  self.Worker = class extends Threads {
    /** @param {string | URL} path @param {WorkerOptions} [options] */
    constructor(path, options) {
      // An address that holds its content: a module's blob is refused to a page opened as a file.
      super(`data:text/javascript;base64,${btoa(first + atob(files[String(path)]))}`, options);
    }
  };
}
