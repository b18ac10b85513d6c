import { defineConfig } from 'vite'

// The program embeds what is built. `npx vite` serves the sources beside a station at 127.0.0.1:8080.
export default defineConfig({
  // The page of a station, and that of an archive.
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 300,
    rollupOptions: { input: ['index.html', 'archive.html'] },
  },
  server: { proxy: { '/api': 'http://127.0.0.1:8080' } },
})
