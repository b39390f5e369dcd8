#!/bin/sh
# Waiting for a picture that workers compute. playwright-core 1.65.1, Chromium 156 as /usr/bin/chromium.
#
# Guess: waitForFunction asks an asynchronous function again until its promise gives true, as it does with others.
# Seen: it waits for the first promise and returns, also with false: a promise itself counts as true.
# Why it matters: a test of a page whose picture comes from workers goes on before the picture, and passes on a fast machine.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund playwright-core@1.65.1
cat >wait.mjs <<'END'
import assert from "node:assert/strict";
import { chromium } from "playwright-core";

const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
const page = await browser.newPage();
const asked = async (own) => (await page.waitForFunction(own)).jsonValue();
const plain = await asked(() => { window.n = (window.n ?? 0) + 1; return window.n === 3 && window.n; });
const promised = await asked(async () => { window.m = (window.m ?? 0) + 1; return window.m === 3 && window.m; });
console.log("a function:", plain, "an asynchronous function:", promised);
await browser.close();
assert.deepEqual([plain, promised], [3, false]);
END
node wait.mjs
