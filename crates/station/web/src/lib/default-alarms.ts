// The settings of default alarms: words, and the fields of their form. Texts are those of the station's file.

import type { DefaultAlarm, DefaultAlarmSettings } from '../api/types.ts'

/** What each default alarm is about, by its name in the table `alarms` of the station's file. */
const ABOUT: Record<string, string> = {
  fault: 'A gauge reports a fault.',
  stale: 'A gauge delivers no new data.',
  'not-measurable': 'The reading of a gauge does not decide a limit.',
  segment: 'A segment is not running.',
  damage: 'Many telegrams of a segment arrive damaged.',
  database: 'The station does not record.',
}

export const about = (name: string): string => ABOUT[name] ?? ''

export type DefaultForm = Record<keyof DefaultAlarmSettings, string>

export const defaultForm = ({ priority, delay, off_delay, limit, except }: DefaultAlarmSettings): DefaultForm => ({
  priority: priority ?? '',
  delay: delay ?? '',
  off_delay: off_delay ?? '',
  limit: limit == null ? '' : `${limit}`,
  except: (except ?? []).join('\n'),
})

/** The settings of a form. A field that stays keeps its value as the station has sent it. */
export function changedDefault(seen: DefaultAlarmSettings, form: DefaultForm): DefaultAlarmSettings {
  const before = defaultForm(seen)
  const stays = (key: keyof DefaultForm): boolean => form[key] === before[key]
  const text = (key: 'priority' | 'delay' | 'off_delay'): string | null =>
    stays(key) ? (seen[key] ?? null) : form[key].trim() || null
  const names = form.except
    .split('\n')
    .map((name) => name.trim())
    .filter(Boolean)
  return {
    priority: text('priority'),
    delay: text('delay'),
    off_delay: text('off_delay'),
    limit: stays('limit') ? (seen.limit ?? null) : form.limit.trim() === '' ? null : Number(form.limit),
    except: stays('except') ? (seen.except ?? null) : names.length === 0 ? null : names,
  }
}

/** The settings that hold, in one line. */
export function effective({ settings, defaults }: DefaultAlarm): string {
  const priority = settings.priority ?? defaults.priority ?? ''
  if (priority === 'off') return 'off'
  const limit = settings.limit ?? defaults.limit
  const except = settings.except ?? []
  return [
    priority,
    `after ${settings.delay ?? defaults.delay ?? '0 s'}`,
    `ends after ${settings.off_delay ?? defaults.off_delay ?? '0 s'}`,
    ...(limit == null ? [] : [`above ${limit} telegrams per minute`]),
    ...(except.length === 0 ? [] : [`except ${except.join(', ')}`]),
  ].join(', ')
}
