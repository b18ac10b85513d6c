// In the header of all pages and on the wall: the sound of alarms while it sounds, with its button.

import './alarm-sound.css'
import type { JSX } from 'preact'
import { allowSound, hasSound, useAlarmSound } from '../alarm-sound.ts'
import { setSound, useSound } from '../settings.ts'
import { t } from '../texts/texts.ts'

/** Nothing while no alarm sounds. */
export function AlarmSound(): JSX.Element | null {
  const { priority, isRefused, silence } = useAlarmSound()
  if (priority === null) return null
  return (
    <span class="alarm-sound" data-sounds={isRefused ? undefined : priority}>
      {isRefused && (
        <button type="button" onClick={allowSound}>
          {t.sound.allow}
        </button>
      )}
      <button type="button" title={t.sound.sounds(t.priorities[priority])} onClick={silence}>
        <span aria-hidden="true">♪ </span>
        {t.sound.silence}
      </button>
    </span>
  )
}

/** Switches the sound on and off. The browser remembers it. */
export function SoundSwitch(): JSX.Element {
  const isOn = useSound()
  return (
    <label class="sound-switch" title={hasSound ? t.sound.sentence : t.sound.none}>
      <input
        type="checkbox"
        disabled={!hasSound}
        checked={isOn && hasSound}
        onChange={({ currentTarget }) => setSound(currentTarget.checked)}
      />{' '}
      {t.sound.label}
    </label>
  )
}
