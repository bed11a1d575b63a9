// The samples that stand beside the page.

/** A file of the samples. @param {string} name */
export async function sample(name) {
  const response = await fetch(new URL(`samples/${name}`, import.meta.url))
  return new File([await response.blob()], name)
}
