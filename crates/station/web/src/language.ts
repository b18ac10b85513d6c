// The language of the pages: that of the browser until the user chooses one, which this browser keeps.

import { read, write } from './storage.ts'
import { createStore, useStore } from './store.ts'
import { en } from './texts/en.ts'
import { type Language, languageOf, setTexts, type Texts } from './texts/texts.ts'

const KEY = 'language'

/** English is always there; every other language is a file of its own, which only its users load. */
const TABLES: Record<Language, () => Promise<Texts>> = {
  en: () => Promise.resolve(en),
  de: () => import('./texts/de.ts').then(({ de }) => de),
}

const store = createStore<Language>('en')

/** Shows the pages in a language. Without its texts (the station does not answer) they stay as they are. */
async function show(language: Language): Promise<void> {
  const texts = await TABLES[language]().catch(() => null)
  if (texts === null) return
  setTexts(texts)
  document.documentElement.lang = language
  store.set(language)
}

/** Shows the language that the user has chosen here, otherwise the first of the browser's that the pages speak. */
export const startLanguage = (): Promise<void> => show(languageOf(read(KEY), navigator.languages))

export async function chooseLanguage(language: Language): Promise<void> {
  await show(language)
  if (store.get() === language) write(KEY, language)
}

export const useLanguage = (): Language => useStore(store)
