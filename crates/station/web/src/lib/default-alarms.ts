// The settings of default alarms: words, and the fields of their form. Texts are those of the station's file.

import type { DefaultAlarm, DefaultAlarmSettings } from '../api/types.ts'
import { t } from '../texts/texts.ts'

/** What a default alarm is about, by its name in the table `alarms` of the station's file. */
export const about = (name: string): string => {
  const all: Record<string, string> = t.defaultAlarms.about
  return all[name] ?? ''
}

/** A priority of the file, or that the alarm is off. */
export function priorityText(priority: string): string {
  const all: Record<string, string> = { ...t.priorities, off: t.defaultAlarms.off }
  return all[priority] ?? priority
}

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
  if (priority === 'off') return priorityText(priority)
  const limit = settings.limit ?? defaults.limit
  const except = settings.except ?? []
  return [
    priorityText(priority),
    t.defaultAlarms.after(settings.delay ?? defaults.delay ?? '0 s'),
    t.defaultAlarms.endsAfter(settings.off_delay ?? defaults.off_delay ?? '0 s'),
    ...(limit == null ? [] : [t.defaultAlarms.aboveLimit(limit)]),
    ...(except.length === 0 ? [] : [t.defaultAlarms.except(except.join(', '))]),
  ].join(', ')
}
