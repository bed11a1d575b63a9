// The order of a list, as its user moves it.

/** The list with an entry at another place; the same list where it is there already. @template T @param {readonly T[]} list @param {number} from @param {number} to  its place afterwards @returns {readonly T[]} */
export function moved(list, from, to) {
  const place = Math.min(Math.max(to, 0), list.length - 1)
  if (from === place || !(from in list)) return list
  const others = list.filter((_, index) => index !== from)
  return [...others.slice(0, place), list[from], ...others.slice(place)]
}
