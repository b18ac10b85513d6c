// The user who is logged in, and their role.

import {
  fetchSession,
  login as requestLogin,
  logout as requestLogout,
  changePassword as requestNewPassword,
} from './api/calls.ts'
import { csrf, RequestError } from './api/request.ts'
import type { Role, Session } from './api/types.ts'
import { createStore, useStore } from './store.ts'

const ROLES: Role[] = ['viewer', 'operator', 'engineer']

const LOGGED_OUT: Session = { name: '', role: 'viewer', token: '', login: 'logged-out' }

const RETRY_MS = 1_000

export interface SessionState {
  /** `null` before the first answer of the station. */
  session: Session | null
  /** The user whose session has ended without a logout. */
  expiredUser: string | null
}

const store = createStore<SessionState>({ session: null, expiredUser: null })

function update(session: Session, expiredUser: string | null = null): void {
  csrf.token = session.token
  store.set({ session, expiredUser })
}

/** Takes over what the station says about the session. */
function receive(session: Session): void {
  const { session: before, expiredUser } = store.get()
  const hasEnded = before !== null && before.login !== 'logged-out'
  if (session.login === 'logged-out') update(session, hasEnded ? before.name : expiredUser)
  else update(session)
}

/** Asks the station for the session; again and again until its first answer. */
export async function refreshSession(): Promise<void> {
  try {
    receive(await fetchSession())
  } catch {
    if (!store.get().session) setTimeout(() => void refreshSession(), RETRY_MS)
  }
}

export async function login(name: string, password: string): Promise<void> {
  receive(await requestLogin(name, password))
}

export async function changePassword(current: string, next: string): Promise<void> {
  receive(await requestNewPassword(current, next))
}

export async function logout(): Promise<void> {
  try {
    await requestLogout()
  } catch (error) {
    // 401: the session had ended before.
    if (!(error instanceof RequestError && error.status === 401)) throw error
  }
  update(LOGGED_OUT)
}

csrf.onSessionEnd = () => {
  const { session } = store.get()
  if (session && session.login !== 'logged-out') update(LOGGED_OUT, session.name)
}

csrf.refresh = async () => {
  const before = store.get().session
  await refreshSession()
  const { session } = store.get()
  return session?.name === before?.name && session?.token !== before?.token
}

/** Whether the station shows its data: a user is logged in, or the station has no users. */
export function canView(): boolean {
  const { session } = store.get()
  return session !== null && session.login !== 'logged-out'
}

export const onSessionChange = store.subscribe
export const useSessionState = (): SessionState => useStore(store)
export const useSession = (): Session => useSessionState().session ?? LOGGED_OUT

/** Whether the role of the user includes `needed`. */
export const hasRole = ({ role }: Session, needed: Role): boolean => ROLES.indexOf(role) >= ROLES.indexOf(needed)
