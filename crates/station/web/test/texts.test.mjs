// The texts of the pages: every language says everything, and no page has a text of its own.

import assert from 'node:assert/strict'
import { readdirSync, readFileSync } from 'node:fs'
import { test } from 'node:test'
import { fileURLToPath } from 'node:url'
import ts from 'typescript'
import { age } from '../dist/test/lib/format.js'
import { gas, lostSentence, recorderProblem } from '../dist/test/lib/labels.js'
import { de } from '../dist/test/texts/de.js'
import { en } from '../dist/test/texts/en.js'
import { languageOf, setTexts, t } from '../dist/test/texts/texts.js'

const SOURCES = fileURLToPath(new URL('../src/', import.meta.url))

test('the chosen language comes first, then the first of the browser that the pages speak, then English', () => {
  assert.equal(languageOf(null, ['de-AT', 'en']), 'de')
  assert.equal(languageOf(null, ['fr-CH', 'DE', 'en-GB']), 'de')
  assert.equal(languageOf(null, ['en-GB', 'de']), 'en')
  assert.equal(languageOf('en', ['de']), 'en')
  assert.equal(languageOf('de', ['en-GB']), 'de')
  for (const [stored, preferred] of [
    [null, []],
    ['', ['fr']],
    ['toString', ['constructor', 'x-de']],
  ])
    assert.equal(languageOf(stored, preferred), 'en')
})

/** An argument that is a number, a text, and a function that draws a link. */
const SEVEN = Object.assign((text) => text, { toString: () => '7' })

/** All texts of a table by their paths; a function is called with sevens. */
function textsOf(table, path = []) {
  if (typeof table === 'string') return [[path.join('.'), table]]
  if (typeof table === 'function' && table !== SEVEN) return textsOf(table(...Array(5).fill(SEVEN)), path)
  if (table === null || typeof table !== 'object') return []
  return Object.entries(table).flatMap(([key, value]) => textsOf(value, [...path, key]))
}

/** Texts that are the same in both languages. */
const SAME = new Set([
  ...['Alarm', 'Gateway', 'Gateways', 'Name', 'Parameter', 'Station', 'Bus', 'Text', 'Clients', 'Tab', 'Esc'],
  ...['auto', 'normal', 'webhook', 'Pirani', '1 min', '10 min', 'Segment 7', 'Station 7'],
])

test('German has a text of its own for every English one', () => {
  const german = new Map(textsOf(de))
  const english = textsOf(en)
  assert.ok(english.length > 500, `${english.length} texts`)
  assert.deepEqual([...german.keys()].sort(), english.map(([path]) => path).sort())
  const same = english.filter(([path, text]) => german.get(path) === text && /\p{L}{2}/u.test(text) && !SAME.has(text))
  assert.deepEqual(same, [])
})

test('a station of an archive says how many series it shows, and of how many', () => {
  assert.equal(en.archive.series(18, 18), '18 series of the last 7 days')
  assert.equal(en.archive.series(3, 18), '3 of 18 series of the last 7 days')
  assert.match(de.archive.series(3, 18), /^3 von 18 Messreihen/)
  assert.equal(en.archive.atLeast(en.archive.alarms(500)), 'at least 500 active alarms')
})

test('a recorder that does not write comes before a damaged database', () => {
  assert.equal(recorderProblem({ error: null, damage: null }), null)
  assert.match(
    recorderProblem({ error: null, damage: 'page 7' }),
    /^The database is damaged: page 7\. .*restore a backup/,
  )
  assert.equal(recorderProblem({ error: 'disk full', damage: 'page 7' }), 'The recorder does not write: disk full')
})

test('texts with values follow the language that is shown', () => {
  assert.equal(t, en)
  assert.equal(lostSentence({ lost_samples: 0, lost_events: 0 }), null)
  assert.equal(lostSentence({ lost_samples: 2, lost_events: 1 }), '2 samples and 1 event could not be recorded.')
  setTexts(de)
  try {
    assert.equal(age(200), 'weniger als 1 s')
    assert.equal(gas('air'), 'Luft')
    assert.equal(
      lostSentence({ lost_samples: 2, lost_events: 1 }),
      '2 Messwerte und 1 Ereignis konnten nicht aufgezeichnet werden.',
    )
    assert.equal(lostSentence({ lost_samples: 0, lost_events: 1 }), '1 Ereignis konnte nicht aufgezeichnet werden.')
  } finally {
    setTexts(en)
  }
})

/** Words that are no language: units, names of programs and commands, quantities of formulas. */
const NO_LANGUAGE = new Set([
  'profivac',
  'profivac user add',
  'mbar L',
  'mbar L/s',
  'Pa m³/s',
  'L/s',
  'KiB',
  'sccm',
  'ms',
  'min',
  'R',
])

/** Attributes whose text a user reads or hears. */
const READ = new Set([
  ...[
    'aria-label',
    'aria-description',
    'aria-roledescription',
    'aria-valuetext',
    'title',
    'placeholder',
    'alt',
    'label',
  ],
  ...['caption', 'text', 'button', 'empty', 'summary'],
])

const hasWord = (text) => /\p{L}{2}/u.test(text) && !NO_LANGUAGE.has(text.replace(/[^\p{L}³/]+/gu, ' ').trim())

/** The places of a source that have a text of their own, or take a text before the language is known. */
function textsIn(name, source) {
  const file = ts.createSourceFile(name, source, ts.ScriptTarget.ES2022, true)
  const found = []
  const report = (node, text) => {
    const { line } = file.getLineAndCharacterOfPosition(node.getStart())
    found.push(`${name}:${line + 1}: ${text.trim()}`)
  }
  const visit = (node) => {
    if (ts.isImportDeclaration(node) || ts.isTypeNode(node) || isForDevelopers(node)) return
    if (ts.isJsxText(node) && hasWord(node.text)) report(node, node.text)
    else if (isText(node) && isShown(node)) report(node, textOf(node))
    else if (ts.isIdentifier(node) && node.text === 't' && isConstant(node)) report(node, 't outside of a function')
    ts.forEachChild(node, visit)
  }
  visit(file)
  return found
}

const isText = (node) => ts.isStringLiteralLike(node) || ts.isTemplateExpression(node)

/** The literal parts of a text. */
function textOf(node) {
  return ts.isTemplateExpression(node)
    ? [node.head.text, ...node.templateSpans.map(({ literal }) => literal.text)].join(' … ')
    : node.text
}

/** An error that only a developer sees: a hook outside of its place. */
const isForDevelopers = (node) => ts.isThrowStatement(node) && /^throw new Error\('expected a/.test(node.getText())

/** Whether a user sees a text: an attribute that is read, a child of an element, or a sentence anywhere but in a class or a style. */
function isShown(node) {
  const text = textOf(node)
  if (!hasWord(text) || isCompared(node) || isSelector(node)) return false
  for (let at = node; at.parent; at = at.parent) {
    const { parent } = at
    if (ts.isJsxAttribute(parent)) return READ.has(parent.name.getText())
    if (ts.isJsxExpression(parent) && !ts.isJsxAttribute(parent.parent)) return true
    if (ts.isFunctionLike(parent) || ts.isCallExpression(parent)) break
  }
  return isSentence(text)
}

/** A code that is compared or looked up is not shown: `state === 'shelved'`. */
function isCompared(node) {
  const { parent } = node
  const isOperand = ts.isBinaryExpression(parent) && parent.operatorToken.kind !== ts.SyntaxKind.PlusToken
  return (
    (isOperand && !/^(\?\?|\|\||&&)$/.test(parent.operatorToken.getText())) ||
    ts.isElementAccessExpression(parent) ||
    ts.isCaseClause(parent)
  )
}

/** What is looked for in the page or asked of the browser, and the key of a request. */
const isSelector = ({ parent }) =>
  ts.isCallExpression(parent) && /\b(matches|matchMedia|querySelector|useQuery)\b/.test(parent.expression.getText())

/** Two words with a space between them, or one word with a capital letter and small ones. */
const isSentence = (text) => /\p{L}{2,}[,:]? (… )?\p{L}{2,}/u.test(text) || /^\p{Lu}\p{Ll}{2,}$/u.test(text)

/** Whether a constant of a module takes the texts, so that it keeps those of the first language. */
function isConstant(node) {
  const isName = ts.isPropertyAccessExpression(node.parent) && node.parent.name === node
  if (isName || ts.isImportSpecifier(node.parent) || ts.isPropertyAssignment(node.parent)) return false
  for (let at = node.parent; at; at = at.parent) if (ts.isFunctionLike(at)) return false
  return true
}

/** Texts that no language changes. */
const ALLOWED = [
  // Fonts of pictures.
  /px system-ui, sans-serif$/,
  // Names of protocols and programs.
  /: (OPC UA|Modbus TCP|Prometheus)$/,
]

test('German has every sentence about a risk in the tables of the devices', () => {
  const tables = fileURLToPath(new URL('../../../devices/src/', import.meta.url))
  const sentences = readdirSync(tables, { recursive: true })
    .filter((name) => /codes\.rs$/.test(name))
    .flatMap((name) => [
      ...readFileSync(tables + name, 'utf8').matchAll(/(?:risk |RISK: &str = |LIFE: &str = )"([^"]+)"/g),
    ])
    .map(([, text]) => text.replace(/\\\n\s*/g, ''))
  assert.ok(sentences.length > 15, `${sentences.length} sentences`)
  assert.deepEqual(
    sentences.filter((sentence) => de.riskSentence(sentence) === sentence),
    [],
  )
  assert.equal(de.riskSentence('of a device file'), 'of a device file')
})

test('no page has a text of its own', () => {
  const names = readdirSync(SOURCES, { recursive: true })
    .map((name) => name.replaceAll('\\', '/'))
    .filter((name) => /\.tsx?$/.test(name) && !name.startsWith('texts/') && !name.endsWith('.d.ts'))
  assert.ok(names.length > 80, `${names.length} files`)
  const found = names.flatMap((name) => textsIn(name, readFileSync(SOURCES + name, 'utf8')))
  assert.deepEqual(
    found.filter((place) => !ALLOWED.some((allowed) => allowed.test(place))),
    [],
  )
})

test('the search for texts finds each kind', () => {
  for (const source of [
    'const A = () => <p>Waiting …</p>',
    'const A = () => <p title="Waiting" />',
    'const A = () => <Choice label="Gauge" />',
    // biome-ignore lint/suspicious/noTemplateCurlyInString: a source
    'const A = () => <p aria-label={`Segment ${name}`} />',
    "const A = () => <p>{x ? 'none' : y}</p>",
    "const A = () => <p>{x ?? 'unknown'}</p>",
    "const a = () => 'no data'",
    "const A = { title: 'Time' }",
    // biome-ignore lint/suspicious/noTemplateCurlyInString: a source
    'const a = (count) => `${count} more alarms`',
    'const A = [t.common.time]',
  ])
    assert.equal(textsIn('a.tsx', source).length, 1, source)
  for (const source of [
    'const A = () => <p class="connection good" data-kind="alarm">{t.common.time}</p>',
    "const A = () => <p title={t.pages['/alarms']} />",
    "const a = () => x === 'shelved' && <p>{t.common.time}</p>",
    "const A = () => <p>{state === 'shelved' && <b>{t.common.time}</b>}</p>",
    'const A = () => <p>{clock(at)} → 10 mbar L</p>',
    "import { a } from './two words.ts'",
  ])
    assert.deepEqual(textsIn('a.tsx', source), [], source)
})

test('one English text has one German text', () => {
  const flat = (table, path = '') =>
    Object.entries(table).flatMap(([key, value]) => {
      if (typeof value === 'string') return [[path + key, value.toLowerCase()]]
      return typeof value === 'object' ? flat(value, `${path}${key}.`) : []
    })
  // A noun and a verb, an abbreviation, or another meaning.
  const others = ['change', 'end', 'events', 'lost', 'access', 'release control']
  const german = new Map(flat(de))
  const found = new Map()
  for (const [key, text] of flat(en)) found.set(text, new Set([...(found.get(text) ?? []), german.get(key)]))
  const several = [...found].filter(([text, words]) => words.size > 1 && !others.includes(text))
  assert.deepEqual(several, [])
})
