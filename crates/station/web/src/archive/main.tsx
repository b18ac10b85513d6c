// The page of an archive: all stations.

import '../locale.ts'
import '../styles/tokens.css'
import '../styles/base.css'
import '../styles/controls.css'
import '../styles/tables.css'

import { render } from 'preact'
import { Boundary } from '../components/boundary.tsx'
import { showWaitingActions, WaitingActions } from '../components/pending.tsx'
import { startLanguage } from '../language.ts'
import { startSession } from '../session.ts'
import { applyTheme } from '../settings.ts'
import { App } from './app.tsx'
import { startLive } from './live.ts'

applyTheme()
showWaitingActions()
startLive()
void startSession()
const root = document.getElementById('app')
const drawn = (
  <Boundary>
    <App />
    <WaitingActions />
  </Boundary>
)
void startLanguage().then(() => {
  // The sentence for browsers in which nothing is drawn.
  root?.replaceChildren()
  if (root) render(drawn, root)
})
