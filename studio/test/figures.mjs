// The picture of the scene Your own, which stands in the book where the page is not. Usage: node figures.mjs PAGE.html FOLDER
import { writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { open, scene, until } from "./browser.mjs";

const [file, folder] = process.argv.slice(2);
const { context, page } = await open(process.env.CHROMIUM ?? "/usr/bin/chromium");
await scene(page, pathToFileURL(resolve(file)).href, "own?method=possibilistic");
await until(page, (now) => now.ready);
writeFileSync(join(folder, "studio-own.svg"), await page.evaluate(() => window.studio.picture()));
await context.close();
