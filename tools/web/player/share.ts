// Takes the page along: the address of the current view through the system's share sheet or the
// clipboard, the line that embeds the page in another one, and the image on the screen as a file.

const ON_DISK = "this page lies on a disk: put it on a web server, so that others can open it";

/** Whether others can open an address. */
function isOnline(href: string): boolean {
  return href.startsWith("http");
}

/** The line to show, or null where nothing is to be said. */
export async function share(href: string, title: string): Promise<string | null> {
  if (navigator.share !== undefined && isOnline(href)) {
    try {
      await navigator.share({ title, url: href });
      return null;
    } catch (error) {
      if ((error as DOMException).name === "AbortError") return null; // closed by the person
    }
  }
  const copied = await copy(href, "Link copied", "Copy the address of this page: it has this view");
  return isOnline(href) ? copied : `${copied}, but ${ON_DISK}`;
}

async function copy(text: string, done: string, refused: string): Promise<string> {
  try {
    await navigator.clipboard.writeText(text);
    return done;
  } catch {
    return refused;
  }
}

function escaped(text: string): string {
  return text.replace(/&/g, "&amp;").replace(/"/g, "&quot;").replace(/</g, "&lt;");
}

/** One line of HTML. */
export function embedLine(href: string, title: string): string {
  return (
    `<iframe src="${escaped(href)}" title="${escaped(title)}" width="960" height="540" ` +
    `style="border:0" allow="fullscreen; autoplay; xr-spatial-tracking" loading="lazy"></iframe>`
  );
}

/** The line to show. */
export async function shareEmbed(href: string, title: string): Promise<string> {
  if (!isOnline(href)) return `Nothing copied: ${ON_DISK}`;
  const line = embedLine(href, title);
  return copy(line, "Line copied: paste it into the HTML of a page", line);
}

/** "The kitchen 1.25 s.png" */
export function imageName(title: string, seconds: number): string {
  return `${title.replace(/[\\/:*?"<>|\s]+/g, " ").trim() || "Tessera"} ${seconds.toFixed(2)} s.png`;
}

export function saveImage(image: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(image);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
