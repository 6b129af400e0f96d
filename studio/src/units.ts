// Numbers as people read them: SI units, a true minus sign, figures that do not jump.

export const mm = (metres: number): number => 1e3 * metres;
export const degrees = (radians: number): number => (180 / Math.PI) * radians;

/** A number with so many decimals and its unit. */
export function quantity(value: number, decimals: number, unit: string): string {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  const sign = Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
  return unit ? `${sign}\u202f${unit}` : sign;
}

export const moment = (value: number): string => quantity(1e3 * value, 2, "mN m");
export const force = (value: number): string => quantity(1e3 * value, 0, "mN");
export const length = (value: number, decimals = 1): string => quantity(mm(value), decimals, "mm");
export const angle = (value: number): string => quantity(degrees(value), 1, "°");
export const area = (value: number): string =>
  value < 1e-4 ? quantity(1e6 * value, 1, "mm²") : quantity(1e4 * value, 1, "cm²");
