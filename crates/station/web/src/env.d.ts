/** What the build of the station tells the pages. */
interface ImportMeta {
  readonly env: {
    /** Set when the station has no Parquet export. */
    readonly VITE_WITHOUT_PARQUET?: string
  }
}
