// Commands of gauges by words, in the order of their use, and the states that they change.

import type { Block, Command, Gauge } from '../api/types.ts'
import { t } from '../texts/texts.ts'

/** What comes first in the name of a command of the device itself: reset, self-test, storing. */
const DEVICE = 'device.'

/** Commands of the measuring parts in the order of their use. Those that are missing here come behind. */
const USED_FIRST = ['degas-on', 'degas-off', 'emission-on', 'emission-off', 'automatic-mode', 'manual-mode']

const lastPart = (name: string): string => name.slice(Math.max(name.lastIndexOf('.'), name.lastIndexOf('/')) + 1)

const rank = ({ command }: Command): number => {
  const place = USED_FIRST.indexOf(lastPart(command))
  return place < 0 ? USED_FIRST.length : place
}

/** The commands of the measuring parts, the most used first, and those of the device itself. */
export function inUse(commands: Command[]): { parts: Command[]; device: Command[] } {
  // The manuals have commands that do nothing: `inactive` in every block, `ready-to-store` of a controller.
  const real = commands.filter(({ command }) => !['inactive', 'ready-to-store'].includes(lastPart(command)))
  return {
    parts: real.filter(({ command }) => !command.startsWith(DEVICE)).sort((one, other) => rank(one) - rank(other)),
    device: real.filter(({ command }) => command.startsWith(DEVICE)),
  }
}

/** A command in words, with its part where others have the same command; the name of the API where there are no words. */
export function commandWords(command: string, among: Command[]): string {
  const last = lastPart(command)
  const words = Object.hasOwn(t.commands, last) ? t.commands[last as keyof typeof t.commands] : null
  if (words === null) return command
  const isAlone = among.filter((other) => lastPart(other.command) === last).length < 2
  return isAlone ? words : `${words}: ${command.slice(0, -last.length - 1)}`
}

/** A state that commands change. */
export interface OperatingState {
  target: string
  name: string
  text: string
}

const isState = ({ target }: { target: string }): boolean => /(^|\.)(emission|degas)/.test(target)

/** Whether a command changes such a state. */
export const changesState = (command: string): boolean => isState({ target: command }) || /[.-]mode$/.test(command)

/** Emission and degas: as the station reads them again and again for gateways, or else as they were read with all parameters. */
export function operatingStates({ parameters }: Pick<Gauge, 'parameters'>, blocks: Block[] | null): OperatingState[] {
  const watched = parameters.filter((one) => isState(one) && one.quality === 'valid')
  const states = watched.map(({ target, name, text }) => ({ target, name, text }))
  const read = (blocks ?? []).flatMap(({ parameters }) => parameters).filter(isState)
  for (const { target, name, value } of read) {
    if (value !== null && !states.some((state) => state.target === target)) states.push({ target, name, text: value })
  }
  return states
}
