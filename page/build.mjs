// Builds dist/index.html: one file with style, program and worker in it. `--check`: fails if the committed one differs.
import { build } from "esbuild";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";

const here = (path) => new URL(path, import.meta.url);

async function bundle(entry, define = {}) {
  const result = await build({
    entryPoints: [here(entry).pathname],
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    legalComments: "none",
    write: false,
    define,
  });
  return result.outputFiles[0].text.trimEnd();
}

const worker = await bundle("src/worker.ts");
const program = await bundle("src/main.ts", { WORKER_SOURCE: JSON.stringify(worker) });
const style = await build({ entryPoints: [here("src/style.css").pathname], minify: true, charset: "utf8", write: false });
const page = readFileSync(here("src/index.html"), "utf8")
  .replace("/*style*/", () => style.outputFiles[0].text.trimEnd())
  .replace("/*program*/", () => program.replaceAll("</script", "<\\/script"));

const path = here("dist/index.html");
if (process.argv.includes("--check")) {
  if (readFileSync(path, "utf8") !== page) {
    console.error("page/dist/index.html: found another page than page/src builds to, expected the same: npm run build");
    process.exit(1);
  }
} else {
  mkdirSync(here("dist/"), { recursive: true });
  writeFileSync(path, page);
  console.log(`page/dist/index.html: ${(page.length / 1024).toFixed(1)} kB`);
}
