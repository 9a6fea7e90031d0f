import { fileURLToPath } from "node:url";
import react from "@vitejs/plugin-react";
import { type HtmlTagDescriptor, mergeConfig, type Plugin, type UserConfig } from "vite";
import { defineConfig, type ViteUserConfig } from "vitest/config";

/** The server (for `npm run dev`): the port of a running `nrp cockpit EXPERIMENT --no-browser`. */
const server = process.env.NRP_COCKPIT ?? "http://127.0.0.1:8765";

/** Lets the browser fetch and compile the scene beside the first script, not after it: it is in the first picture. */
const sceneAtOnce: Plugin = {
  name: "scene-at-once",
  transformIndexHtml: {
    order: "post",
    handler: (_html, { bundle = {} }) =>
      Object.values(bundle)
        .filter((chunk) => chunk.type === "chunk" && chunk.name === "ScenePanel")
        .flatMap((chunk) => [
          link("modulepreload", chunk.fileName),
          ...[...(chunk.viteMetadata?.importedCss ?? [])].map((file) => link("stylesheet", file)),
        ]),
  },
};

const link = (rel: string, fileName: string): HtmlTagDescriptor => ({
  tag: "link",
  attrs: { rel, crossorigin: true, href: `./${fileName}` },
  injectTo: "head",
});

/** Views that a page with a recording in it does not have. */
const NOT_SHARED = /^.*\/(DesignerView|CompareView|EmbeddedView|StartPage|SweepPage)$/;

/** The page for `nrp share`, which puts its one script and one style sheet into a file with a recording. */
const shared: UserConfig = {
  resolve: {
    alias: [{ find: NOT_SHARED, replacement: fileURLToPath(new URL("src/Nothing.tsx", import.meta.url)) }],
  },
  publicDir: false,
  build: {
    outDir: "../src/nrp_cockpit/static/shared",
    cssCodeSplit: false,
    rolldownOptions: {
      input: "src/main.tsx",
      output: { codeSplitting: false, entryFileNames: "page.js", assetFileNames: "page[extname]" },
    },
    chunkSizeWarningLimit: 2000,
  },
};

const served: UserConfig = {
  plugins: [sceneAtOnce],
  build: {
    outDir: "../src/nrp_cockpit/static",
    chunkSizeWarningLimit: 650, // three.js and the editor, each fetched when its room opens
  },
};

const common: ViteUserConfig = {
  base: "./",
  plugins: [react()],
  build: {
    emptyOutDir: true,
    license: { fileName: "licenses.md" }, // of what is bundled
    target: "es2023",
    assetsInlineLimit: 0, // the content security policy of the server allows no data: scripts
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
  },
  server: { proxy: { "/ws": { target: server, ws: true, changeOrigin: true } } },
  // a process for each file takes longer than its tests
  test: { include: ["src/**/*.test.{ts,tsx}"], pool: "threads", isolate: false },
};

export default defineConfig(({ mode }) => mergeConfig(common, mode === "shared" ? shared : served));
