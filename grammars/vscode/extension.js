// Starts "tissuec lsp" for files of tissuec. VS Code runs client.js, which docs/make_client.py
// makes of this file and its packages.
"use strict";

const vscode = require("vscode");
const node = require("vscode-languageclient/node");

let client;

async function activate() {
  const settings = vscode.workspace.getConfiguration("tissuec");
  const command = settings.get("command", "tissuec");
  const server = { command, args: ["lsp"], transport: node.TransportKind.stdio };
  const selector = [
    { scheme: "file", language: "tissuec" },
    { scheme: "untitled", language: "tissuec" },
  ];
  client = new node.LanguageClient("tissuec", "tissuec", server, {
    documentSelector: selector,
    initializationOptions: { libraries: settings.get("libraries", []) },
    synchronize: { fileEvents: vscode.workspace.createFileSystemWatcher("**/*.{tis,csv,obj,stl,ply,vtk,vtp,vtu,msh,feb,nrrd,nhdr,nii,nii.gz}") },
  });
  try {
    await client.start();
  } catch (error) {
    vscode.window.showErrorMessage(
      `tissuec: cannot start "${command} lsp". Is it installed? pip install "tissuec[lsp]"`
    );
  }
}

function deactivate() {
  return client && client.stop();
}

module.exports = { activate, deactivate };
