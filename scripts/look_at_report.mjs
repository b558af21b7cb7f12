#!/usr/bin/env node
// Opens pages in a headless browser at 1280 and 400 px, leaves pictures of them to be looked at, and fails if something is
// fetched, is said on the console, or is wider than the window.
//
//     scripts/look_at_report.mjs FOLDER report.html...
//
// Needs Node 20 and Chromium (Debian: chromium; another place: CHROMIUM=/path), and once `npm install --no-save puppeteer-core`.
import { mkdirSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [folder, ...pages] = process.argv.slice(2);
if (!pages.length) {
  console.error("usage: scripts/look_at_report.mjs FOLDER report.html...");
  process.exit(2);
}
mkdirSync(folder, { recursive: true });
const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const browser = await puppeteer.launch({ executablePath, args: ["--no-sandbox"] });
let faults = 0;
for (const path of pages) {
  for (const width of [1280, 400]) {
    const page = await browser.newPage();
    const found = [];
    const own = pathToFileURL(resolve(path)).href;
    page.on("console", (message) => found.push(`console: ${message.text()}`));
    page.on("pageerror", (error) => found.push(`error: ${error}`));
    page.on("request", (request) => request.url() !== own && found.push(`fetched: ${request.url()}`));
    await page.setViewport({ width, height: 900 });
    await page.goto(own);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    if (wide > 0) found.push(`${wide} px wider than the window`);
    const picture = join(folder, `${basename(dirname(resolve(path)))}_${width}.png`);
    await page.screenshot({ path: picture, fullPage: true });
    console.log(`${path} at ${width} px: ${found.length ? found.join("; ") : "fine"}; ${picture}`);
    faults += found.length;
    await page.close();
  }
}
await browser.close();
process.exit(faults ? 1 : 0);
