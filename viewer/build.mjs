// Builds src/ into the package's assets: npm ci && npm run build
import { build } from "esbuild";
import { copyFile } from "node:fs/promises";

const assets = "../src/sherd/report/assets";
const shared = { bundle: true, minify: true, legalComments: "eof", target: "es2022", charset: "utf8" };
await build({ ...shared, entryPoints: ["src/main.js"], outfile: `${assets}/viewer.js`, format: "iife" });
await build({ ...shared, entryPoints: ["src/style.css"], outfile: `${assets}/viewer.css` });
await copyFile("src/page.html", `${assets}/page.html`);
