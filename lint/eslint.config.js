import js from "@eslint/js";

export default [
  js.configs.recommended,
  { rules: { "no-undef": "off", "no-var": "error", "prefer-const": ["error", { destructuring: "all" }] } },  // tsc finds unknown names
];
