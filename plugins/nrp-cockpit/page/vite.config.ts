import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";

/** The server (for `npm run dev`): the port of a running `nrp cockpit EXPERIMENT --no-browser`. */
const server = process.env.NRP_COCKPIT ?? "http://127.0.0.1:8765";

export default defineConfig({
  base: "./",
  plugins: [react()],
  build: {
    outDir: "../src/nrp_cockpit/static",
    emptyOutDir: true,
    target: "es2023",
    assetsInlineLimit: 0, // the content security policy of the server allows no data: scripts
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
    chunkSizeWarningLimit: 650, // three.js and the editor, each fetched when its room opens
  },
  server: { proxy: { "/ws": { target: server, ws: true, changeOrigin: true } } },
  test: { include: ["src/**/*.test.ts"] },
});
