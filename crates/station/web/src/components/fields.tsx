// Fields of filter bars.

import type { JSX } from 'preact'

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

interface SearchProps {
  label: string
  value: string
  placeholder?: string
  onInput: (text: string) => void
}

export function SearchField({ label, value, placeholder = 'Search', onInput }: SearchProps): JSX.Element {
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
