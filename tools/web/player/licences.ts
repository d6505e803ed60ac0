// The licences of the libraries that are built into the page; package-lock.json lists their
// versions.
import fflate from "../node_modules/fflate/LICENSE?raw";
import spark from "../node_modules/@sparkjsdev/spark/LICENSE?raw";
import three from "../node_modules/three/LICENSE?raw";

export const LICENCES = [
  `Tessera's player: Apache License 2.0, https://www.apache.org/licenses/LICENSE-2.0`,
  `three.js\n\n${three.trim()}`,
  `Spark (@sparkjsdev/spark)\n\n${spark.trim()}`,
  `fflate, within Spark\n\n${fflate.trim()}`,
].join("\n\n-----\n\n");
