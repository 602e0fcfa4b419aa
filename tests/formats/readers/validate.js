// Runs the Khronos glTF validator over .glb files: no errors and no warnings are allowed.
// Issues are not limited: after so many, be they mere infos, the validator gives up and says nothing of the rest.
// usage: node validate.js MODULES FILE…

const fs = require('fs');
const path = require('path');

const [modules, ...files] = process.argv.slice(2);
const validator = require(path.join(modules, 'gltf-validator'));

(async () => {
    for (const file of files) {
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 0 });
        const { numErrors, numWarnings, numInfos, messages } = report.issues;
        // Of a file that is none there is no more to say than that.
        const { totalVertexCount = 0, totalTriangleCount = 0 } = report.info ?? {};
        console.log(`${path.basename(file)}: ${totalVertexCount} vertices, ${totalTriangleCount} triangles, ` +
            `${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos`);
        messages.filter((message) => message.severity < 2).forEach((message) => console.error(message));
        if (numErrors + numWarnings > 0 || totalTriangleCount === 0) process.exitCode = 1;
    }
})();
