// Light or dark: as the system says, until the reader chooses.

const root = document.documentElement;
const dark = window.matchMedia("(prefers-color-scheme: dark)");

function show() {
  const button = document.getElementById("theme");
  const now = root.dataset.theme ?? (dark.matches ? "dark" : "light");
  button.textContent = now === "dark" ? "Light" : "Dark";
  button.setAttribute("aria-label", `Switch to ${now === "dark" ? "light" : "dark"} colors`);
}

export const theme = {
  start() {
    document.getElementById("theme").addEventListener("click", () => theme.toggle());
    dark.addEventListener("change", show);
    show();
  },
  toggle() {
    const now = root.dataset.theme ?? (dark.matches ? "dark" : "light");
    root.dataset.theme = now === "dark" ? "light" : "dark";
    show();
  },
};
