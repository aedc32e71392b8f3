// What a canvas shows, as it is saved: its pixels, by cell too.

import { decode } from "./png.mjs";

/** The canvas's own pixels, not the screen's. */
export async function shot(page, canvas = "#canvas-0") {
  await page.ready();
  const url = await page.page.$eval(canvas, (c) => c.toDataURL("image/png"));
  return onCells(page, Buffer.from(url.split(",")[1], "base64"), canvas);
}

/** A picture of a canvas, and the colour in the middle of a cell. */
export async function onCells(page, bytes, canvas = "#canvas-0") {
  const picture = decode(bytes);
  const [box] = [await (await page.page.$(canvas)).boundingBox()];
  const ratio = await page.page.evaluate(() => window.devicePixelRatio);
  const { viewport } = await page.state();
  const cell = (column, row) => {
    const x = box.width / 2 + (column + 0.5 - viewport.centre[0]) * viewport.scale;
    const y = box.height / 2 - (row + 0.5 - viewport.centre[1]) * viewport.scale;
    return picture.at(Math.floor(x * ratio), Math.floor(y * ratio));
  };
  return { ...picture, cell, pixels: bytes.toString("base64") };
}
