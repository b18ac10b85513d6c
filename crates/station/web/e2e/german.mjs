// Whether a page is German: its language, and no English text of the pages that is not marked as English.

import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { violations } from './axe.mjs'

/** The texts of a table in its source: those without a value, and the parts of those with values that are three words or more. */
function textsOf(language) {
  const source = readFileSync(new URL(`../src/texts/${language}.ts`, import.meta.url), 'utf8')
  const lines = source.slice(source.indexOf(`export const ${language}`)).replace(/^\s*(\/\*\*|\/\/).*$/gm, '')
  const whole = [...lines.matchAll(/'((?:[^'\\\n]|\\.)*)'(?!\]?:)/g)].map(([, text]) => text)
  const parts = [...lines.matchAll(/`([^`]*)`/g)].flatMap(([, text]) => text.split(/\$\{[^}]*\}/))
  return {
    whole: new Set(whole.filter((text) => /\p{L}{2}/u.test(text)).map((text) => text.trim())),
    parts: parts.map((text) => text.trim()).filter((text) => text.split(/\s+/).length > 2),
  }
}

const ENGLISH = textsOf('en')
const WORDS = textsOf('de')

/** The texts that a user of this page reads or hears and that are English in the table of texts. */
async function englishOn(page) {
  const shown = await page.evaluate(() => {
    const found = [document.title.split(' · ')[0]]
    // Words of manuals and sentences of the station say that they are English.
    const isGerman = (element) => element.closest('[lang]').lang === 'de'
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT)
    while (texts.nextNode()) if (isGerman(texts.currentNode.parentElement)) found.push(texts.currentNode.data)
    for (const element of [...document.querySelectorAll('*')].filter(isGerman))
      for (const name of ['aria-label', 'title', 'placeholder']) found.push(element.getAttribute(name) ?? '')
    return [...new Set(found.map((text) => text.replace(/\s+/g, ' ').trim()))]
  })
  const isEnglish = (text) =>
    (ENGLISH.whole.has(text) && !WORDS.whole.has(text)) || ENGLISH.parts.some((part) => text.includes(part))
  return shown.filter(isEnglish)
}

/** The page is German, without English texts, and axe finds nothing. */
export async function check(page, what, without = []) {
  assert.equal(await page.evaluate(() => document.documentElement.lang), 'de', what)
  assert.deepEqual(await englishOn(page), [], what)
  // A header that stays covers what is scrolled below it.
  await page.evaluate(() => scrollTo(0, 0))
  assert.deepEqual(await violations(page, without), [], what)
}
