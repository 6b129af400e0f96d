// A preprocessor of mdbook: fenced blocks ```math become MathML, which browsers show without scripts, fonts or a network.
//
// As mdbook calls it: `preprocess.mjs supports RENDERER`, or the book as JSON on the standard input.
// `preprocess.mjs --check FILE…` tries every equation of these pages.

import { readFileSync } from "node:fs";
import katex from "katex";

const block = /^```math\n([\s\S]*?)^```$/gm;

function typeset(source) {
  const math = katex.renderToString(source.trim(), { displayMode: true, output: "mathml", throwOnError: true, strict: "error" });
  // One line: a blank one would end the block of HTML within Markdown.
  return `<div class="equation">${math.replace(/\s*\n\s*/g, " ")}</div>`;
}

function replaced(page) {
  return page.replace(block, (_, source) => typeset(source));
}

function walk(items) {
  for (const item of items) {
    if (item.Chapter) {
      item.Chapter.content = replaced(item.Chapter.content);
      walk(item.Chapter.sub_items);
    }
  }
}

const [mode, ...rest] = process.argv.slice(2);
if (mode === "supports") {
  process.exit(rest[0] === "html" ? 0 : 1);
} else if (mode === "--check") {
  let count = 0;
  for (const file of rest) {
    for (const [, source] of readFileSync(file, "utf8").matchAll(block)) {
      count += 1;
      try {
        typeset(source);
      } catch (error) {
        console.error(`${file}: ${error.message}\n${source}`);
        process.exitCode = 1;
      }
    }
  }
  console.log(`${count} equations in ${rest.length} pages`);
} else {
  const [, book] = JSON.parse(readFileSync(0, "utf8"));
  walk(book.items ?? book.sections);
  console.log(JSON.stringify(book));
}
