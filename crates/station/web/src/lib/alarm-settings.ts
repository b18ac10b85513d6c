// The fields of the settings of an alarm. Texts are those of the station's file.

import type { Alarm, AlarmSettings, Gauge } from '../api/types.ts'
import { t } from '../texts/texts.ts'
import { type Extreme, extremeOf } from './pressure-range.ts'
import { pascals } from './units.ts'

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

/** The default of the station, in decades. */
const HYSTERESIS = 0.1

/** The station accepts no larger hysteresis and no faster rise. */
const MAX_DECADES = 10

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
    placeholder: () => String(HYSTERESIS),
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

/** Whether the alarm ends at a value that its settings name. */
export const hasReset = (settings: AlarmSettings): boolean => hasPressure(settings) || has('rise')(settings)

/** The value at which the condition of an alarm ends, in the unit of its limit. */
export interface Reset {
  value: number
  unit: 'Pa' | 'decades/min'
}

/** The value at which the condition ends with the settings of a form; `null` if the station would refuse them. */
export function resetOf({ above, below, rise, reset, hysteresis }: SettingsForm): Reset | null {
  if (rise.trim() !== '') return riseReset(rise, hysteresis)
  const isAbove = above.trim() !== ''
  const limit = pascals(isAbove ? above : below)
  if (limit === null || limit === 0) return null
  const pa = reset.trim() === '' ? byHysteresis(limit, hysteresis, isAbove) : given(reset, hysteresis, limit, isAbove)
  return pa === null ? null : { value: pa, unit: 'Pa' }
}

function byHysteresis(limit: number, hysteresis: string, isAbove: boolean): number | null {
  const decades = decadesOf(hysteresis, HYSTERESIS)
  return decades === null ? null : limit * 10 ** (isAbove ? -decades : decades)
}

/** A reset value of its own: not together with a hysteresis, and not beyond the limit. */
function given(reset: string, hysteresis: string, limit: number, isAbove: boolean): number | null {
  const pa = pascals(reset)
  if (pa === null || hysteresis.trim() !== '') return null
  return (isAbove ? pa <= limit : pa >= limit) ? pa : null
}

function riseReset(rise: string, hysteresis: string): Reset | null {
  const limit = decadesOf(rise, 0)
  if (limit === null || limit === 0) return null
  const less = decadesOf(hysteresis, limit / 2)
  return less === null ? null : { value: limit - less, unit: 'decades/min' }
}

/** The number in a field, which has this value while it is empty. */
function decadesOf(text: string, otherwise: number): number | null {
  const decades = text.trim() === '' ? otherwise : Number(text)
  return decades >= 0 && decades <= MAX_DECADES ? decades : null
}

/** A pressure that an alarm watches, or the end of the range that it is beyond. */
export interface Watched extends Extreme {
  series: string
}

/** The pressures that an alarm watches, without those that are not known. */
export function watchedPressures({ series, several }: Alarm, gauges: readonly Gauge[], sinceMs: number): Watched[] {
  return (several?.series ?? [series]).flatMap((wanted) =>
    gauges.flatMap((gauge) =>
      gauge.readings.flatMap((reading) => {
        const extreme = reading.series === wanted ? extremeOf(gauge, reading, sinceMs) : null
        return extreme ? [{ ...extreme, series: reading.series }] : []
      }),
    ),
  )
}
