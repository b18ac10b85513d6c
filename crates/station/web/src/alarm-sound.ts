// Plays the sound of alarms in one window of the browser, while the user has switched it on.

import { useEffect, useState } from 'preact/hooks'
import type { Priority } from './api/types.ts'
import { NEXT_PULSE_S, PULSE_S, silencedOf, silencing, soundingPriority, TONES, type Tone } from './lib/alarm-sound.ts'
import { useLive } from './live.ts'
import { useSound } from './settings.ts'
import { read, write } from './storage.ts'
import { createStore, useStore } from './store.ts'

/** chosen: clear in a quiet room, and no fright. The computer has a control of its own. */
const VOLUME = 0.3

/** The edge of a pulse, without which it begins and ends with a click. */
const EDGE_S = 0.01

/** All windows of the browser share it, and a page that is loaded again keeps it. */
const KEY = 'silenced-alarms'
const silenced = createStore(silencedOf(read(KEY)))

addEventListener('storage', ({ key, newValue }) => {
  if (key === KEY) silenced.set(silencedOf(newValue))
})

export const hasSound = 'AudioContext' in globalThis

/** One for the page: a browser has few of them. */
let context: AudioContext | null = null

const audio = (): AudioContext => {
  context ??= new AudioContext()
  return context
}

/** Allows the sound, which browsers refuse to a page that nobody has pressed. */
export const allowSound = (): void => void audio().resume()

/** Plays a tone once. */
function play(on: AudioContext, { hertz, pulses }: Tone): void {
  const [oscillator, volume] = [on.createOscillator(), on.createGain()]
  oscillator.frequency.value = hertz
  oscillator.connect(volume).connect(on.destination)
  volume.gain.value = 0
  for (let pulse = 0; pulse < pulses; pulse += 1) {
    const begin = on.currentTime + pulse * NEXT_PULSE_S
    volume.gain.setValueAtTime(0, begin)
    volume.gain.linearRampToValueAtTime(VOLUME, begin + EDGE_S)
    volume.gain.setValueAtTime(VOLUME, begin + PULSE_S - EDGE_S)
    volume.gain.linearRampToValueAtTime(0, begin + PULSE_S)
  }
  oscillator.start()
  oscillator.stop(on.currentTime + pulses * NEXT_PULSE_S)
}

/**
 * Runs in one window at a time, until the returned function is called: several windows would sound at once. Without locks, which a browser
 * has only on a secure page, each window runs.
 */
function inOneWindow(run: () => () => void): () => void {
  let end: (() => void) | null = null
  let isOver = false
  const begin = (): void => {
    if (!isOver) end = run()
  }
  if ('locks' in navigator) {
    const over = new AbortController()
    const held = async (): Promise<void> => {
      begin()
      await new Promise<void>((done) => over.signal.addEventListener('abort', () => done()))
    }
    navigator.locks.request('alarm-sound', { signal: over.signal }, held).catch(() => {})
    return () => {
      isOver = true
      end?.()
      over.abort()
    }
  }
  begin()
  return () => {
    isOver = true
    end?.()
  }
}

/** What the page shows of the sound. */
export interface Sound {
  /** The priority that sounds now, or would if the browser allowed it. */
  priority: Priority | null
  /** Whether the browser waits for a press. */
  isRefused: boolean
  silence: () => void
}

/** Plays the tone of the highest priority again and again. Only one component of a page may use it. */
export function useAlarmSound(): Sound {
  const isOn = useSound() && hasSound
  const { snapshot } = useLive()
  const silent = useStore(silenced)
  const alarms = snapshot?.alarms.alarms ?? []
  const priority = isOn ? soundingPriority(alarms, silent) : null
  const isRefused = useIsRefused(isOn)
  useEffect(() => {
    if (priority === null || isRefused) return
    const tone = TONES[priority]
    return inOneWindow(() => {
      play(audio(), tone)
      const timer = setInterval(() => play(audio(), tone), tone.everyMs)
      return () => clearInterval(timer)
    })
  }, [priority, isRefused])
  const silence = (): void => {
    const next = silencing(alarms)
    silenced.set(next)
    write(KEY, JSON.stringify([...next]))
  }
  return { priority, isRefused, silence }
}

/** Whether the browser still refuses the sound. Any press and any key on the page allows it. */
function useIsRefused(isOn: boolean): boolean {
  const [isRefused, setRefused] = useState(false)
  useEffect(() => {
    if (!isOn) return
    const on = audio()
    const changed = (): void => setRefused(on.state !== 'running')
    changed()
    on.addEventListener('statechange', changed)
    for (const event of ['pointerdown', 'keydown']) addEventListener(event, allowSound)
    void on.resume()
    return () => {
      on.removeEventListener('statechange', changed)
      for (const event of ['pointerdown', 'keydown']) removeEventListener(event, allowSound)
    }
  }, [isOn])
  return isRefused
}
