// The page of an archive: all stations.

import '../styles/tokens.css'
import '../styles/base.css'
import '../styles/controls.css'
import '../styles/tables.css'

import { render } from 'preact'
import { startLanguage } from '../language.ts'
import { startSession } from '../session.ts'
import { applyTheme } from '../settings.ts'
import { App } from './app.tsx'
import { startLive } from './live.ts'

applyTheme()
startLive()
void startSession()
const root = document.getElementById('app')
void startLanguage().then(() => root && render(<App />, root))
