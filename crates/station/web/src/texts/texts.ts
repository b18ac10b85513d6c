// The texts of the pages in the language that is shown.

import { en } from './en.ts'

/** What every language has: TypeScript refuses a table in which a text is missing or superfluous. */
export type Texts = typeof en

/** The texts of the present language. Read them while drawing: a constant of a module would keep the first language. */
export let t: Texts = en

export function setTexts(texts: Texts): void {
  t = texts
}

/** The languages by their codes, each under its own name. */
export const LANGUAGES = { en: 'English', de: 'Deutsch' } as const
export type Language = keyof typeof LANGUAGES

const isLanguage = (code: string): code is Language => Object.hasOwn(LANGUAGES, code)

/** The stored language, otherwise the first that the browser prefers and the pages speak, otherwise English. */
export function languageOf(stored: string | null, preferred: readonly string[]): Language {
  const codes = [stored ?? '', ...preferred].map((tag) => tag.toLowerCase().split('-')[0] ?? '')
  return codes.find(isLanguage) ?? 'en'
}
