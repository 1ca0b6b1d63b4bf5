// Builds src/ into the package's assets: npm ci && npm run build
// or, as a test does, into another folder: npm run build -- folder
import { build } from "esbuild";
import { copyFile, readFile } from "node:fs/promises";

const assets = process.argv[2] ?? "../src/sherd/report/assets";
// every report is a copy of these libraries, so every report carries their licenses
const licenses = await Promise.all(["three", "three-mesh-bvh"].map(
  async (name) => `${name}\n\n${(await readFile(`node_modules/${name}/LICENSE`, "utf8")).trim().replaceAll("\u00a9", "(c)")}`));
const shared = { bundle: true, minify: true, legalComments: "none", target: "es2022" };
await build({
  ...shared, entryPoints: ["src/main.js"], outfile: `${assets}/viewer.js`, format: "iife",
  footer: { js: `/*! Bundled libraries\n\n${licenses.join("\n\n")}\n*/` },
});
await build({ ...shared, entryPoints: ["src/style.css"], outfile: `${assets}/viewer.css` });
await copyFile("src/page.html", `${assets}/page.html`);
