// The controls of landmarks and of regions to ignore, and their files.
import { choices, integer, make, number } from "./panel.js";

const $ = (id) => document.getElementById(id);
export const MODES = ["look", "landmarks", "ignore"];
const TITLES = { look: "Look", landmarks: "Landmarks", ignore: "Ignore" };
const HINTS = {
  look: "Click a point to see its partner.", landmarks: "Click both ends of a landmark.", ignore: "Drag over the part to mark it.",
};
const BRUSHES = ["Add", "Erase"];

export class HintsPanel {
  constructor(page) {
    this.page = page;
    this.hints = page.hints;
  }

  fill() {
    const { page, hints } = this;
    $("hints-card").hidden = false;
    choices($("modes"), "mode", MODES.map((mode) => ({ title: TITLES[mode] })), (index) => page.setMode(MODES[index]));
    choices($("brushes"), "brush", BRUSHES.map((title) => ({ title })), (index) => page.setBrush({ erase: index === 1 }));
    $("brush-radius").addEventListener("input", (event) => page.setBrush({ percent: Number(event.target.value) }));
    $("ignore-nothing").addEventListener("click", () => page.changeHints(() => hints.ignoreNothing()));
    this.form("landmark-form", () => {
      const part = hints.vertex("part", $("landmark-part").value), full = hints.vertex("full", $("landmark-full").value);
      page.changeHints(() => hints.add(part, full));
    });
    this.form("brush-form", () => page.brushNumber(hints.vertex("part", $("brush-vertex").value)));
    $("save-landmarks").addEventListener("click", () => save("landmarks.csv", hints.landmarksCsv));
    $("save-ignored").addEventListener("click", () => save("ignore.csv", hints.ignoredCsv));
    $("load-hints").addEventListener("change", (event) => this.load(event.target));
    copyOnClick($("copy-hints"), $("hints-command"));
  }

  form(id, act) {
    $(id).noValidate = true; // what is wrong is said in the page, and stays
    $(id).addEventListener("submit", (event) => {
      event.preventDefault();
      this.say("");
      try {
        act();
      } catch (error) {
        this.say(error.message);
      }
    });
  }

  async load(input) {
    const said = [];
    for (const file of input.files) {
      const text = await file.text();
      try {
        this.page.changeHints(() => said.push(this.hints.load(file.name, text)));
      } catch (error) {
        said.push(error.message);
      }
    }
    input.value = "";
    this.say(said.length ? `${said.join("; ")}.` : "");
  }

  say(words) {
    $("hints-message").textContent = words;
  }

  refresh() {
    const { hints, page } = this;
    const { mode, brush } = page.state;
    document.querySelector(`input[name="mode"][value="${MODES.indexOf(mode)}"]`).checked = true;
    document.querySelector(`input[name="brush"][value="${brush.erase ? 1 : 0}"]`).checked = true;
    const ignored = hints.ignoredNumbers.length;
    const some = hints.landmarks.length > 0 || ignored > 0;
    $("tools-landmarks").hidden = mode !== "landmarks";
    $("tools-ignore").hidden = mode !== "ignore";
    $("hints-files").hidden = mode === "look" && !some;
    $("save-landmarks").disabled = hints.landmarks.length === 0;
    $("save-ignored").disabled = ignored === 0;
    $("brush-radius").value = brush.percent;
    $("brush-size").textContent = number(page.brushRadius, 3);
    $("ignored-count").textContent = `${integer(ignored)} of ${integer(page.fileCount("part"))} vertices are ignored.`;
    $("landmark-next").textContent = this.next();
    $("hints-command-row").hidden = !some;
    $("hints-command").textContent = page.hintsCommand();
    page.panel.hint(HINTS[mode]);
    this.list();
  }

  next() {
    const { part, full } = this.hints.pending;
    if (part !== null) return `Now its partner on the full shape (part vertex ${integer(part)}).`;
    if (full !== null) return `Now its partner on the part (full vertex ${integer(full)}).`;
    return "Click a point of the part, then its partner on the full shape.";
  }

  list() {
    const list = $("landmark-list");
    list.replaceChildren();
    this.hints.landmarks.forEach(({ part, full }, index) => {
      const row = make("div", {}, make("li", {}, list));
      make("span", { text: `part ${integer(part)}, full ${integer(full)}` }, row);
      const button = make("button", { type: "button", class: "quiet", text: "Delete", "aria-label": `Delete landmark ${index + 1}` }, row);
      button.addEventListener("click", () => this.page.changeHints(() => this.hints.remove(index)));
    });
  }
}

function save(name, text) {
  const address = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

// Copies the text of an element; where the clipboard is closed the text is selected.
export function copyOnClick(button, source) {
  button?.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(source.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(source);
      button.textContent = "Press Ctrl+C";
    }
    setTimeout(() => (button.textContent = "Copy"), 1500);
  });
}
