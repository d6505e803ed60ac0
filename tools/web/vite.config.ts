// Builds the page that PAGE names as one file: script and style are written into its index.html,
// with the licences of its libraries at the top.
import { readFileSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";

const LIBRARIES: Record<string, string[]> = {
  player: ["three", "@sparkjsdev/spark", "fflate"],
  report: ["uplot"],
};
const PAGE = process.env.PAGE ?? "player";
const INDEX = `${PAGE}/index.html`;

const NOTICES = LIBRARIES[PAGE].map((name) => {
  const folder = new URL(`node_modules/${name}/`, import.meta.url);
  const { version } = JSON.parse(readFileSync(new URL("package.json", folder), "utf8"));
  return `${name} ${version}\n\n${readFileSync(new URL("LICENSE", folder), "utf8").trim()}`;
});

const HEADING = `<!--\nTessera's ${PAGE}. It contains:\n\n${NOTICES.join("\n\n")}\n-->\n`;

function oneFile(): Plugin {
  return {
    name: "one-file",
    enforce: "post",
    generateBundle(_options, bundle) {
      const page = bundle[INDEX];
      if (page?.type !== "asset") throw new Error("the build made no page");
      let html = String(page.source);
      for (const [name, item] of Object.entries(bundle)) {
        if (item === page) continue;
        const text = String(item.type === "chunk" ? item.code : item.source);
        const source = text.replace(/\/\/# sourceMappingURL=[\w.-]+/g, ""); // would be asked for
        const escaped = name.replace(/\W/g, "\\$&");
        const tag = new RegExp(`[ \\t]*<(script|link)[^>]*${escaped}[^>]*>(</script>)?\\n?`);
        if (!tag.test(html)) throw new Error(`${name} is not in ${INDEX}: it cannot be one file`);
        html = html.replace(tag, "");
        const inline =
          item.type === "chunk"
            ? `<script type="module">${source.replace(/<\/(script)/gi, "<\\/$1")}</script>\n`
            : `<style>${source}</style>\n`;
        const end = item.type === "chunk" ? "</body>" : "</head>";
        const place = html.lastIndexOf(end);
        html = html.slice(0, place) + inline + html.slice(place);
        delete bundle[name];
      }
      page.source = html.replace(/^(<!doctype html>\n)/i, (doctype) => doctype + HEADING);
      page.fileName = `${PAGE}.html`;
    },
  };
}

export default defineConfig({
  base: "./",
  publicDir: false,
  build: {
    target: "es2022",
    rollupOptions: { input: INDEX },
    assetsInlineLimit: Number.MAX_SAFE_INTEGER,
    cssCodeSplit: false,
    modulePreload: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 8192,
  },
  worker: { format: "iife" }, // browsers start no module from a blob of a file:// page
  plugins: [oneFile()],
});
