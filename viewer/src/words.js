// Numbers as people read them.

const plain = new Intl.NumberFormat("en-US");

export const integer = (value) => plain.format(value);

export function number(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "unknown";
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3)) return value.toExponential(digits - 2);
  return String(Number(value.toPrecision(digits)));
}

export const percent = (share) => `${number(100 * share, 3)} %`;

// No more digits than the packed data hold.
export function coordinates(point, extent) {
  const decimals = Math.max(0, Math.floor(-Math.log10(extent / 65534)));
  if (decimals > 9 || extent >= 1e9) return point.map((value) => number(value, 5)).join(", ");
  return point.map((value) => value.toFixed(decimals)).join(", ");
}

// Round numbers between low and high, about six.
export function ticks(low, high) {
  const raw = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 2.5, 5, 10].find((nice) => nice * power >= raw * (1 - 1e-9));
  const out = [];
  for (let i = Math.ceil(low / step - 1e-9); i <= Math.floor(high / step + 1e-9); i++) out.push(Number((i * step).toPrecision(12)));
  return out;
}
