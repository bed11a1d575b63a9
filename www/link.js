// Settings in a link: what stands after its # is not sent to any server.

const MARK = '#settings='

/** The link to this page with settings. @param {string} text */
export function linkTo(text) {
  // Brackets and marks are escaped as well, which programs that find links in a text would leave out at their end.
  const escaped = encodeURIComponent(text).replace(/[!'()*]/g, (mark) => `%${mark.charCodeAt(0).toString(16)}`)
  return location.href.replace(/#.*$/s, '') + MARK + escaped
}

/**
 * The text of the settings in the address, which is taken out of it: none where there are none, and what cannot be
 * decoded as it stands.
 * @returns {string | undefined}
 */
export function takeFromAddress() {
  const { hash } = location
  if (!hash.startsWith(MARK)) return undefined
  history.replaceState(null, '', location.href.replace(/#.*$/s, ''))
  const written = hash.slice(MARK.length)
  try {
    return decodeURIComponent(written)
  } catch {
    return written
  }
}
