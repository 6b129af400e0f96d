// One self-contained page: TypeScript, styles and the library into dist/studio.html. Usage: node bundle.mjs LIBRARY.wasm
import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const here = new URL(".", import.meta.url).pathname;
/** The whole page, compressed as a server would send it (bytes). */
const MOST = 700e3;

async function bundle(entry, define = {}) {
  const { outputFiles } = await build({
    entryPoints: [`${here}src/${entry}`], bundle: true, minify: true, write: false, format: "iife", target: "es2022",
    loader: { ".svg": "text", ".toml": "text" }, define, logLevel: "warning",
  });
  return outputFiles[0].text;
}

/** The module without names and other custom sections. */
function bare(module) {
  const parts = [module.subarray(0, 8)];
  let at = 8;
  while (at < module.length) {
    const [start, kind] = [at++, module[at - 1]];
    let [size, shift, byte] = [0, 0, 0];
    do {
      byte = module[at++];
      size |= (byte & 127) << shift;
      shift += 7;
    } while (byte & 128);
    at += size;
    if (kind !== 0) parts.push(module.subarray(start, at));
  }
  return Buffer.concat(parts);
}

/** As a .lzma file whose header tells the size, by xz: code packs best without contexts of positions. */
function packed(bytes) {
  const lzma = execFileSync("xz", ["--format=lzma", "--lzma1=preset=9e,lc=4,lp=0,pb=0", "-c"], { input: bytes, maxBuffer: 1 << 28 });
  lzma.writeBigUInt64LE(BigInt(bytes.length), 5);
  return lzma;
}

const library = packed(bare(readFileSync(process.argv[2])));
const worker = await bundle("worker.ts");
const script = await bundle("main.ts", {
  WORKER_SOURCE: JSON.stringify(worker),
  LIBRARY: JSON.stringify(library.toString("base64")),
});
const { outputFiles } = await build({ entryPoints: [`${here}src/style.css`], minify: true, write: false });
const page = readFileSync(`${here}src/index.html`, "utf8")
  .replace("/*STYLE*/", () => outputFiles[0].text)
  .replace("/*SCRIPT*/", () => script.replaceAll("</script", "<\\/script"));
mkdirSync(`${here}dist`, { recursive: true });
writeFileSync(`${here}dist/studio.html`, page);
const sent = gzipSync(page, { level: 9 }).length;
const kB = (bytes) => `${(bytes / 1e3).toFixed(0)} kB`;
console.log(`studio/dist/studio.html: ${kB(page.length)}, compressed ${kB(sent)} (library ${kB(library.length)})`);
if (sent > MOST) {
  console.error(`the page is larger than ${kB(MOST)} compressed`);
  process.exit(1);
}
