// Who sits here, and what they may do.

import { useEffect, useState } from 'preact/hooks'
import * as api from './api.ts'
import type { Role, Session } from './api.ts'

const ROLES: Role[] = ['viewer', 'operator', 'engineer']

/** Nobody is known to be more than a viewer before the station says so. */
const NOBODY: Session = { name: '', role: 'viewer', token: '', door: 'out' }

const AGAIN_MS = 1_000

export interface Here {
  /** Nothing before the station has answered for the first time. */
  session: Session | null
  /** Whose session has ended without their doing. */
  lost: string | null
}

let here: Here = { session: null, lost: null }
const listeners = new Set<() => void>()

function become(session: Session | null, lost: string | null = null): void {
  here = { session, lost }
  api.proof.token = session?.token ?? ''
  listeners.forEach((listener) => listener())
}

/** Takes what the station says about who sits here. */
function take(session: Session): void {
  const before = here.session
  const lost = session.door === 'out' && before && before.door !== 'out' ? before.name : here.lost
  become(session, session.door === 'out' ? lost : null)
}

/** Asks the station who sits here, until it answers for the first time. */
export async function whoami(): Promise<void> {
  try {
    take(await api.session())
  } catch {
    if (!here.session) setTimeout(() => void whoami(), AGAIN_MS)
  }
}

export async function login(name: string, password: string): Promise<void> {
  take(await api.login(name, password))
}

export async function changePassword(current: string, next: string): Promise<void> {
  take(await api.changePassword(current, next))
}

/** Whatever the station says: here nobody sits any more. */
export async function logout(): Promise<void> {
  try {
    await api.logout()
  } catch (error) {
    if (!(error instanceof api.Refused && error.status === 401)) throw error
  }
  become(NOBODY)
}

api.proof.ended = () => {
  if (here.session && here.session.door !== 'out') become(NOBODY, here.session.name)
}

api.proof.renewed = async () => {
  const before = here.session
  await whoami()
  return here.session?.name === before?.name && here.session?.token !== before?.token
}

/** Whether the station lets us look. */
export const isIn = (): boolean => here.session !== null && here.session.door !== 'out'

export function onChange(listener: () => void): () => void {
  listeners.add(listener)
  return () => void listeners.delete(listener)
}

export function useHere(): Here {
  const [shown, setShown] = useState(here)
  useEffect(() => {
    const changed = (): void => setShown(here)
    // It may have changed between the first drawing and here.
    changed()
    return onChange(changed)
  }, [])
  return shown
}

export const useSession = (): Session => useHere().session ?? NOBODY

/** Whether somebody with this role may do what `needed` is needed for. */
export const may = ({ role }: Session, needed: Role): boolean => ROLES.indexOf(role) >= ROLES.indexOf(needed)
