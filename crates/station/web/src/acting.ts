// Acting on gauges: commands and parameters in two steps, and who may. Types as src/api/acting.rs has them.

import { address, get, post, Refused, remove, type Mastership, type Risk, type Role } from './api.ts'

export interface Command {
  command: string
  name: string
  numbers: string
  conditions: string[]
  risk: Risk
  role: Role
  barred: string | null
}

/** A condition, and whether it holds. */
export interface Held {
  wanted: string
  found: string
  holds: boolean
}

/** What is to be armed: a command, or a parameter and its value. */
export type Wish = { command: string } | { target: string; value: string }

export interface Armed {
  order: string
  gauge: string
  target: string
  manual: string
  is_command: boolean
  before: string | null
  after: string
  octets: string
  risk: Risk
  conditions: Held[]
  left_ms: number
}

export interface Outcome {
  order: string
  gauge: string
  target: string
  octets: string
  before: string | null
  after: string | null
}

export interface Audited {
  id: number
  at_ms: number
  what:
    | 'fired'
    | 'outcome'
    | 'refused'
    | 'disarmed'
    | 'mastership'
    | 'acknowledged'
    | 'taken-out-of-service'
    | 'returned-to-service'
  of: number | null
  who: string
  role: string
  peer: string | null
  gauge: string | null
  segment: string | null
  address: number | null
  target: string | null
  before: string | null
  after: string | null
  outcome: string | null
  order: string | null
}

export type Move = 'ask' | 'release' | 'grant' | 'take-over'

const of = (gauge: string): string => `/api/gauges/${encodeURIComponent(gauge)}`

export const commands = (gauge: string, signal?: AbortSignal): Promise<Command[]> =>
  get(`${of(gauge)}/commands`, {}, signal)
export const arm = (gauge: string, wish: Wish): Promise<Armed> => post(`${of(gauge)}/arm`, wish)
export const fire = (order: string): Promise<Outcome> => post(`/api/orders/${order}/fire`, null)
export const disarm = (order: string): Promise<void> => remove(`/api/orders/${order}`)
export const pass = (move: Move): Promise<Mastership> => post(`/api/mastership/${move}`, null)

/** The conditions that a refusal speaks of. */
export function conditionsOf(error: unknown): Held[] {
  return (error instanceof Refused && (error.body as { conditions?: Held[] } | null)?.conditions) || []
}

export interface Filter {
  gauge: string
  who: string
  from: number | null
  to: number | null
  most: number
}

function query({ gauge, who, from, to, most }: Filter): Record<string, string | number> {
  return {
    most,
    ...(gauge ? { gauge } : {}),
    ...(who ? { who } : {}),
    ...(from === null ? {} : { from }),
    ...(to === null ? {} : { to }),
  }
}

export const audit = (filter: Filter, signal?: AbortSignal): Promise<Audited[]> =>
  get('/api/audit', query(filter), signal)
export const auditAddress = (filter: Filter): string => address('/api/audit.csv', query({ ...filter, most: 100_000 }))
