// Shares the address of the current view: through the system's share sheet where the browser has
// one, else through the clipboard.

/** The line to show, or null where nothing is to be said. */
export async function share(href: string, title: string): Promise<string | null> {
  if (navigator.share !== undefined && href.startsWith("http")) {
    try {
      await navigator.share({ title, url: href });
      return null;
    } catch (error) {
      if ((error as DOMException).name === "AbortError") return null; // closed by the person
    }
  }
  try {
    await navigator.clipboard.writeText(href);
    return "Link copied";
  } catch {
    return "Copy the address of this page: it has this view";
  }
}
