// The pictures of scenes that stand in the book where the page is not. Usage: node figures.mjs PAGE.html FOLDER
import { writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { open, scene } from "./browser.mjs";

const [file, folder] = process.argv.slice(2);
const { context, page } = await open(process.env.CHROMIUM ?? "/usr/bin/chromium");
for (const [name, hash] of [["preimage", "preimage?room=arena"], ["own", "own?method=possibilistic"]]) {
  await scene(page, pathToFileURL(resolve(file)).href, hash);
  await page.waitForTimeout(6000);
  writeFileSync(join(folder, `studio-${name}.svg`), await page.evaluate(() => window.studio.picture()));
}
await context.close();
