// Builds the loader as one module; three.js and Spark are those of the page that uses it.
import { defineConfig } from "vite";

export default defineConfig({
  publicDir: false,
  build: {
    target: "es2022",
    lib: { entry: "src/index.ts", formats: ["es"], fileName: "tessera4d-loader" },
    rollupOptions: { external: ["three", "@sparkjsdev/spark"] },
    reportCompressedSize: false,
  },
  worker: { format: "iife" },
});
