// What three.js makes of a GLB with a morph target: node three.mjs FILE VERTEX, beside node_modules.
import { readFile } from "node:fs/promises";
import { Vector3 } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

globalThis.self = globalThis; // the loader asks what a browser can do
const [file, vertex] = [process.argv[2], Number(process.argv[3])];
const data = await readFile(file);
const bytes = data.buffer.slice(data.byteOffset, data.byteOffset + data.length);
const mesh = (await new GLTFLoader().parseAsync(bytes, "")).scene.getObjectByName("fit");
const weights = [...mesh.morphTargetInfluences];
const at = (weight) => {
  mesh.morphTargetInfluences[0] = weight;
  return mesh.getVertexPosition(vertex, new Vector3()).toArray();
};
const { position, uv } = mesh.geometry.attributes;
console.log(JSON.stringify({
  count: position.count, targets: mesh.morphTargetDictionary, weights,
  "at 0": at(0), "at 1": at(1), uv: [uv.getX(vertex), uv.getY(vertex)],
}));
