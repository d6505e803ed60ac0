// The limit in bytes for decoded Gaussians, from what the browser reports of the machine.
const DESKTOP = 768 << 20;
const SMALL = 256 << 20; // phones, and machines of 4 GB or less

export function memoryBudget(): number {
  const { deviceMemory } = navigator as { deviceMemory?: number };
  const small = deviceMemory !== undefined ? deviceMemory <= 4 : navigator.maxTouchPoints > 2;
  return small ? SMALL : DESKTOP;
}
