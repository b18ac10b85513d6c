// Fields of filter bars.

import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { momentOf } from '../lib/format.ts'
import { t } from '../texts/texts.ts'

interface ChoiceProps {
  label: string
  value: string
  /** Values and their texts. */
  options: readonly (readonly [value: string, text: string])[]
  onChange: (value: string) => void
}

/** A choice of one of several values. */
export function Choice({ label, value, options, onChange }: ChoiceProps): JSX.Element {
  return (
    <select aria-label={label} value={value} onChange={(event) => onChange(event.currentTarget.value)}>
      {options.map(([value, text]) => (
        <option value={value} key={value}>
          {text}
        </option>
      ))}
    </select>
  )
}

/** For choices whose values are their texts. */
export const sameText = (values: readonly string[]): [string, string][] => values.map((value) => [value, value])

interface MomentProps {
  label: string
  value: string
  onInput?: (text: string) => void
  onChange?: (text: string) => void
}

/**
 * A time as a text in ISO form: the field of the browser shows it as its language does, also with AM and PM. What is
 * typed stays until it is a time or the value changes: a page that is drawn again meanwhile does not take it away.
 */
export function MomentField({ label, value, onInput, onChange }: MomentProps): JSX.Element {
  const [typed, setTyped] = useState<{ text: string; over: string } | null>(null)
  return (
    <input
      class="moment"
      type="text"
      placeholder={t.common.momentForm}
      title={t.common.momentForm}
      aria-label={label}
      autocomplete="off"
      value={typed?.over === value ? typed.text : value}
      onInput={(event) => {
        const text = event.currentTarget.value
        event.currentTarget.setCustomValidity('')
        setTyped({ text, over: value })
        onInput?.(text)
      }}
      onChange={(event) => {
        const text = event.currentTarget.value
        const isWrong = text !== '' && momentOf(text) === null
        event.currentTarget.setCustomValidity(isWrong ? t.common.momentExpected(t.common.momentForm, text) : '')
        if (isWrong) event.currentTarget.reportValidity()
        else if (onChange) {
          setTyped(null)
          onChange(text)
        }
      }}
    />
  )
}

interface SearchProps {
  label: string
  value: string
  placeholder?: string
  onInput: (text: string) => void
}

export function SearchField({ label, value, placeholder = t.common.search, onInput }: SearchProps): JSX.Element {
  return (
    <input
      type="search"
      placeholder={placeholder}
      aria-label={label}
      value={value}
      onInput={(event) => onInput(event.currentTarget.value)}
    />
  )
}
