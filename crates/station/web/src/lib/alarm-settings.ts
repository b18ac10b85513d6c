// The fields of the settings of an alarm. Texts are those of the station's file.

import type { Alarm, AlarmSettings } from '../api/types.ts'
import { t } from '../texts/texts.ts'

export type SettingsForm = Record<keyof AlarmSettings, string>

export interface Field {
  key: keyof AlarmSettings
  label: () => string
  /** The default. */
  placeholder?: () => string
  isNumber?: boolean
  /** The alarm has no default for it. */
  isLimit?: boolean
  /** Whether an alarm with these settings has the field. */
  shown: (settings: AlarmSettings) => boolean
}

const has = (key: keyof AlarmSettings) => (settings: AlarmSettings) => (settings[key] ?? null) !== null
const hasPressure = (settings: AlarmSettings): boolean => has('above')(settings) || has('below')(settings)

export const FIELDS: Field[] = [
  { key: 'above', label: () => t.alarmSettings.above, isLimit: true, shown: has('above') },
  { key: 'below', label: () => t.alarmSettings.below, isLimit: true, shown: has('below') },
  { key: 'rise', label: () => t.alarmSettings.rise, isNumber: true, isLimit: true, shown: has('rise') },
  {
    key: 'repetitions',
    label: () => t.alarmSettings.repetitions,
    isNumber: true,
    isLimit: true,
    shown: has('repetitions'),
  },
  { key: 'lost', label: () => t.alarmSettings.lost, isNumber: true, isLimit: true, shown: has('lost') },
  { key: 'damaged', label: () => t.alarmSettings.damaged, isNumber: true, isLimit: true, shown: has('damaged') },
  {
    key: 'hysteresis',
    label: () => t.alarmSettings.hysteresis,
    placeholder: () => '0.1',
    isNumber: true,
    shown: hasPressure,
  },
  {
    key: 'hysteresis',
    label: () => t.alarmSettings.riseHysteresis,
    placeholder: () => t.alarmSettings.halfTheRise,
    isNumber: true,
    shown: has('rise'),
  },
  {
    key: 'reset',
    label: () => t.alarmSettings.reset,
    placeholder: () => t.alarmSettings.byTheHysteresis,
    shown: hasPressure,
  },
  { key: 'window', label: () => t.alarmSettings.window, placeholder: () => '30 s', shown: has('rise') },
  { key: 'delay', label: () => t.alarmSettings.delay, placeholder: () => '1 s', shown: () => true },
  { key: 'off_delay', label: () => t.alarmSettings.offDelay, placeholder: () => '5 s', shown: () => true },
]

const NUMBERS = new Set<keyof AlarmSettings>(FIELDS.filter(({ isNumber }) => isNumber).map(({ key }) => key))

const KEYS: (keyof AlarmSettings)[] = [...new Set(FIELDS.map(({ key }) => key)), 'priority']

/** Whether the file of the station lists the alarm: a default alarm has a condition of another kind. */
export const hasSettings = ({ condition }: Alarm): boolean =>
  ['above', 'below', 'rise', 'several', 'bus-rate'].includes(condition)

export const formOf = (settings: AlarmSettings): SettingsForm =>
  Object.fromEntries(KEYS.map((key) => [key, `${settings[key] ?? ''}`])) as SettingsForm

/** The settings of a form. A field that stays keeps its value as the station has sent it. */
export function changed(seen: AlarmSettings, form: SettingsForm): AlarmSettings {
  const before = formOf(seen)
  const entries = KEYS.map((key) => {
    const text = form[key].trim()
    if (form[key] === before[key]) return [key, seen[key] ?? null]
    if (text === '') return [key, null]
    return [key, NUMBERS.has(key) ? Number(text) : text]
  })
  return { ...seen, ...Object.fromEntries(entries) }
}
