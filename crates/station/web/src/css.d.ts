/** The text of a style sheet, for a tree of its own. */
declare module '*.css?inline' {
  const text: string
  export default text
}
